"""Families of slip models and kinds of filters; names only, so that the command line can show them quickly."""

from __future__ import annotations

from enum import StrEnum

#: p1 to p6 of the paper, offsets p7 to p9 of the track ICRs, and errors p10 and p11 of the speeds' scale.
PARAMETERS = 11
GEOMETRIC = 9


class SlipModel(StrEnum):
    """Which parameters are learned: the paper's with offsets, the paper's alone, offsets, all with factors, none."""

    PARAMETRIC = "parametric"
    PAPER = "paper"
    CONSTANT = "constant"
    FACTORS = "factors"
    NONE = "none"

    @property
    def learned(self) -> range:
        """Indices of the parameters that may differ from zero."""
        return {
            SlipModel.PARAMETRIC: range(GEOMETRIC),
            SlipModel.PAPER: range(6),
            SlipModel.CONSTANT: range(6, GEOMETRIC),
            SlipModel.FACTORS: range(PARAMETERS),
            SlipModel.NONE: range(0),
        }[self]


class FilterKind(StrEnum):
    """What is compared with a pose: the motion of the last window, or the mean velocity since the last pose."""

    WINDOW = "window"
    VELOCITY = "velocity"
