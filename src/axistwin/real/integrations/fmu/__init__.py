"""FMUs: scenes as components of Simulink, Dymola, OpenModelica and other simulation tools, by FMI 3.0."""
