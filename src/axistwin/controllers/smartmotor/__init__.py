"""Animatics SmartMotor with firmware 4.76: a servo motor that runs its own language."""

from axistwin.controllers.smartmotor.card import PRODUCTS

__all__ = ["PRODUCTS"]
