"""Soft sliders in steps of time: heat, ageing, thresholds that grow, delay; re-forming backward and turns.

State (`ContactsInSteps`): X, the time, and contacts in groups that were born together at one stretch. A group is a
stretch x, its largest |x| so far, a weight (the share of all contacts born in it), and a record, the numbers by which a
`Memory` tells which share of it still holds: none where contacts break only at thresholds that stay, integrals of their
rate with heat, the density of their thresholds where these age.

One step, of a chosen size (`Steps.step`):
1. The size is divided into travel and time, by a guess.
2. All groups move by the travel, and their records change in the time; a new cohort, the groups that are born together,
   is added (`ContactsInSteps.trial`).
3. Number conservation gives the births in the step, half of which belong to the cohort at its begin, half to the new
   one; with a delay, births follow from past breaks (`BreaksInSteps`). Hence F.
4. The division is changed until K (X_T - X) = F, by the secant method; the step is taken (`ContactsInSteps.take`).

In formulas: s a step's size, τ how much of it is time (`TriedStep.time_part`), I `TriedStep.imbalance`, B breaks
(`Trial.breaks`) and J births (`Trial.births`) per contact up to its end, J_0 births up to its begin.

A slip begins where a longer step would end earlier: the spring then pulls more than contacts can bear
(`SlipBegins.up_to_slip`). It ends, at the same time, at the first balance ahead; the slip rule says whether broken
contacts form again on the way ("instant"), after it ("reform-after"), or whether all are replaced ("reset")
(`slip_ends.py`). With a delay "instant" is "reform-after": a slip takes no time, so that no delay ends in it. Steps go
from one to the next section of the drive's motion, which end where it turns, changes speed or holds, where births jump
a delay after such an instant, and at slips (`Slider`). What follows on a slip that leaves all contacts new
is solved once on a leg of the drive.

Order of calls: `solve_soft` (soft/solution.py); `refined`, which for each halving makes a Memory and the contacts, and
calls `Slider.run`; there, at each begin of a section, `Slider._begin_section`, which lets all begin anew that remember
steps; then for each step `SlipBegins.up_to_slip`, which asks for many trials, and `ContactsInSteps.take` of the one
that is chosen. Only `take` and what a slip does change the contacts. In a slip contacts are changed first, and X, or
the slip's list, follows from their force.

Clocks: all times here are on the path, from t = 0 on, `ContactsInSteps.now` and ends of trials, too (legs of a rigid
slider have clocks of their own, those of a soft one have not). Sizes (`Node.sizes_so_far`) and steps of time
(`StepCount`) are counted from the begin of a section; breaks and births from t = 0 or the last slip that replaced all
contacts.

Signs: `Trial.travel`, X, F and stretches have that of X. Along the slider's motion (`Steps.sign`), which is that of the
drive or, where it creeps the other way, of the spring's pull, are counted sizes, `Steps.travelled`, imbalances, and all
of `SlipSoFar`.

Refinement (`refined`): the whole path is solved with steps, and the meshes of records, halved each time. Errors fall as
the square of the steps: three solutions with as many slips give the limit, and an error from their changes, to which
those of the memory, rounding and what steps cannot resolve (`Unresolved`) are added (`extrapolated`). Where that is
above the tolerance the message names the largest of these parts (`Followed.why_above`).

In reading order: `refining.py`, `slider.py`, `steps.py`, `slip_begins.py`, `slip_ends.py`, `decohered.py` (where a long
slip leads to), `contacts.py`, `groups.py`, `breaks.py`, `unresolved.py`, the folder `answer` (what three sliders tell,
and how well), and `creep.py`, by which a slider that creeps on a soft spring goes on to the end of the path without
steps (`Slider._crept_to_end`).
Then the memories: `memory.py` (what a memory is, and thresholds that stay), `threshold_cells.py` (integrals of rates at
the ends of cells, with the compiled sums of `threshold_cells_kernel.py`), `changing.py` for thresholds that change,
with `cells.py` and the compiled `cells_kernel.py` where they age; and `idle_heat.py`, for heat too weak for steps to
see. A plain twin: `tests/plain_in_time.py`.

Tests: tests/test_plain_in_time.py for parts by themselves, each memory and the plain twin, in seconds;
test_soft_laws.py and test_any_spring.py for slips. A delay: test_births_follow_from_the_breaks_one_delay_before, the
plain twin; slips: test_contacts_that_break_in_a_slip_wait_out_their_delay.
"""
