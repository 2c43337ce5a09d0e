"""Slip models and filters to choose from; on their own, so that the command line can name them quickly."""

from __future__ import annotations

from trackctl.identification.slip_model import FilterKind, SlipModel

__all__ = ["FilterKind", "SlipModel"]
