"""What one teller says of a slider under a slip rule: the master equation, sliders of finitely many contacts, or steady
sliding. Each teller fills a record of its own. Where another one tells in its place, its record is replaced as a whole
(`Behaviour.in_place_of`), so that no number of the one stands beside numbers of the other."""

from dataclasses import dataclass, field, replace

import numpy as np

from origins.thresholds.law import Array
from toolkit.results.rarer import Rarer
from toolkit.results.slips import Spread
from toolkit.verdict.sliders.slips_in_time import SlipsOfMass

# fields of a Behaviour that say how the slider was followed, and what it was asked about; all others are its teller's
AS_ASKED = ("rule", "delay", "damping", "heat_left_out", "unstable_below", "refused", "run_time")


@dataclass(frozen=True)
class Finite:
    """What sliders of `contacts` contacts each do under a slip rule.

    contacts : of each slider; fewer than there are where these take too long, see `message`
    kind : "stick-slip" where each slider slips, more often than infinitely many do before these slide (and again, where
        they do), "smooth" where none does, on a way of some 40 mean thresholds, "now and then" between; "ever rarer"
        where slips get rarer along the way and steady sliding is stable; "unknown" where they were not followed, or not
        until it is known whether the `slips` that were seen go on, or slip where nobody knows how often infinitely many
        do, for the reason in `message`
    before, after : mean spring force before and after late slips (`late_slips`), F/(N_c <k>) (lengths), with standard
        errors
    slips : number of slips of a slider, mean
    period, period_error : of the drive, between late slips, mean and standard error (lengths); None and nan where there
        are none
    drive, force : the trace of the first slider, F/(N_c <k>) (lengths), with each slip at its own place
    late, late_error : mean force over the last part of the way (of BEYOND), and its standard error, where none slips or
        contacts re-form at once, F/(N_c <k>) (lengths); nan of others, and with a mass, whose damping bears a part, but
        where what infinitely many do is not known
    rises : whether the force still rises there, as the sliders do not yet go with the drive
    fluctuation : standard deviation of the force there between sliders, which is that along the drive of each as they
        slide steadily (a length), as `late`, and with a mass; where slips get ever rarer that between slips; nan of
        others
    befores, drops, periods : how the force before a slip, its fall (F/(N_c <k>)), and the drive's way between two slips
        differ from one late slip to the next (lengths); None for fewer than two
    smaller : how many slips were left out beside main ones, of all sliders, see `main_slips`
    shrinks_by : part of itself by which a drop is smaller than the one before it, see `shrinks_by`; 0 where it is not
    rarer : how slips get rarer along the way; None where they do not
    still_changing : forces before slips in order, F/(N_c <k>) (lengths), where few slips still grow, or shrink
    in_time : what their slips tell where these take time
    """

    rule: str
    contacts: int
    kind: str
    before: float = float("nan")
    before_error: float = float("nan")
    after: float = float("nan")
    after_error: float = float("nan")
    slips: float = 0.0
    message: str = ""
    drive: Array = field(default_factory=lambda: np.empty(0))
    force: Array = field(default_factory=lambda: np.empty(0))
    period: float | None = None
    period_error: float = float("nan")
    late: float = float("nan")
    late_error: float = float("nan")
    rises: bool = False
    fluctuation: float = float("nan")
    befores: Spread | None = None
    drops: Spread | None = None
    periods: Spread | None = None
    smaller: int = 0
    shrinks_by: float = 0.0
    rarer: Rarer | None = None
    still_changing: tuple[float, ...] = ()
    in_time: SlipsOfMass = field(default_factory=SlipsOfMass)

    @property
    def force_error(self) -> float:
        """Of the forces of its slips (a length)."""
        return max(self.before_error, self.after_error)


@dataclass(frozen=True)
class Behaviour:
    """What a slider does under one rule; forces F/(N_c <k>) and distances are lengths.

    delay : of contacts, where another one than theirs was tried (a time); None: their own
    rule : "reset", "reform-after" or "instant"; "mass" where mass, damping and delay decide
    kind : "stick-slip", "smooth", "ever rarer" (see Finite), or "undecided"
    before, after : spring force before and after a slip, the last main one (see Slips.main), also where it is
        undecided whether more follow; both the sliding force where it is smooth
    peak : largest spring force between the slip before and this one, at the points of the path: a spring near K* gives
        way past the peak; nan where it is not looked at
    period : of the drive, from the last main slip but one to the last
    slips : how many there were, all of infinitely many contacts, main ones of each slider of an ensemble
        Of infinitely many contacts whose slips go on and differ in size, before, after and period are means over the
        later half of the main slips.
    period_error : of the period (a length), from above; where slips differ with the standard error of its mean, of the
        ensemble this and what fewer contacts than there are may change
    finite : what tells it of finitely many contacts, whose means of late slips the numbers are; None: no such slips
    instead : why the master equation does not decide, where sliders of all contacts do in its place; "" where it does
    in_time : what its slips tell where these take time
    damping : γ/(N_c <k>) (time) of a mass without one, which was taken for it to come to rest; None: as given
    contacts : of each of the ensemble's sliders that tell it; None: infinitely many, by the master equation
    error : of the force, in mean thresholds: estimated from above, with the standard error of the mean drop where slips
        differ; by the ensemble one standard error between sliders, and what fewer contacts than there are may change
    cut : whether the path was not followed to its end
    heat_left_out : what heat that was left out changes in the force at most, in mean thresholds, a part of `error`;
        None where there is no heat, or it was followed
    heat_on_the_way : where steady sliding tells of it (in_heat.py), what heat, which is left out on the way up to
        that, changes in F_k and F_s at most, in mean thresholds; 0 where that way was not followed; None: it was
    unstable_below : K/(N_c <k>) below which steady sliding is unstable, of one in heat that is not decided, or slides;
        0 where it is stable on this spring; None, nan: not looked at, not known
    shrinks_by : part of itself by which a drop is smaller than the one before it; 0 where drops do not shrink
    left : the drop of slips that go on to shrink so at the path's end, F/(N_c <k>) (a length)
    few_break : the largest share of the contacts that breaks in a slip, where all slips are resets of fewer than
        SLIP_FRACTION (origins/drive.py), and so none of the slider; None of others
    swings : between which the force of smooth sliding still swings there, F/(N_c <k>) (lengths); None where it hardly
        does, and where that is not known
    smaller : how many slips the numbers leave out beside main ones
    refused : whether the master equation takes no such slider, for the reason in `message`
    drive, force : the trace, with each slip at its own place
    slip_drive, slip_force : the trace of one slip and of the swing after it, densely; empty where it is not looked at
    """

    rule: str
    kind: str
    before: float
    after: float
    period: float | None
    slips: int
    error: float
    success: bool
    message: str
    run_time: float
    in_time: SlipsOfMass = field(default_factory=SlipsOfMass)
    damping: float | None = None
    contacts: int | None = None
    finite: Finite | None = None
    cut: bool = False
    heat_left_out: float | None = None
    heat_on_the_way: float | None = None
    unstable_below: float | None = None
    shrinks_by: float = 0.0
    left: float = 0.0
    period_error: float = 0.0
    peak: float = float("nan")
    few_break: float | None = None
    swings: tuple[float, float] | None = None
    smaller: int = 0
    delay: float | None = None
    refused: bool = False
    instead: str = ""
    drive: Array = field(default_factory=lambda: np.empty(0))
    force: Array = field(default_factory=lambda: np.empty(0))
    slip_drive: Array = field(default_factory=lambda: np.empty(0))
    slip_force: Array = field(default_factory=lambda: np.empty(0))

    def in_place_of(self, other: "Behaviour") -> "Behaviour":
        """All that this teller says, in place of what `other` said of the same slider: how that was asked stays."""
        return replace(self, **{name: getattr(other, name) for name in AS_ASKED})

    @property
    def without_heat(self) -> bool:
        """Whether its trace, and the slips that were seen, or looked for, are those of contacts without their heat."""
        return self.heat_left_out is not None or bool(self.heat_on_the_way)


def not_followed(rule: str, why: str) -> Behaviour:
    """A behaviour that could not be found, and why."""
    nan = float("nan")
    return Behaviour(rule, "undecided", nan, nan, None, 0, float("inf"), False, why, 0.0)


def ends_before_a_slip(found: Behaviour) -> bool:
    """Whether a slider can be followed no further, however much time there is, and has not slipped by then."""
    from master.soft.in_time.refining import NO_SLIP_YET

    return found.message.endswith(NO_SLIP_YET)
