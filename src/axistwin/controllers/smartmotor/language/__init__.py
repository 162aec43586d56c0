"""The SmartMotor language: lexer, parser, expressions, compiled programs."""
