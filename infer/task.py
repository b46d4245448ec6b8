"""What a rig hands to the inference."""

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field

from benchtwin.infer.conditions import Condition, Contact
from benchtwin.infer.explanation import Alternative, Explanation
from benchtwin.infer.finding import Curve
from benchtwin.infer.power_law import Law
from benchtwin.infer.problem import Fit
from benchtwin.infer.unlisted import Windows


@dataclass(frozen=True, eq=False)
class DiagnosisTask:
    """What a rig hands to the inference."""

    rig: str
    alternatives: tuple[Alternative, ...]  # of its baseline
    windows: Callable[[Fit], Windows]  # of unlisted physics
    curves: Callable[[Fit, Fit], tuple[Curve, ...]]  # (base, model): for the report
    contact: Mapping[str, Callable[[Explanation], tuple[float, float]]] = field(
        default_factory=dict
    )
    law: Callable[[Fit], Law] = lambda fit: ()  # of unlisted physics
    # what to record next
    advice: Callable[[tuple[str, ...]], str | None] = lambda names: None
    notes: tuple[str, ...] = ()
    remarks: Callable[[Fit], tuple[str, ...]] = lambda fit: ()  # notes on what was fit
    # what may follow which conditions
    follows: tuple[Contact, tuple[Condition, ...]] | None = None
