"""Soft sliders in steps of time: heat, ageing, thresholds that grow, delay; re-forming backward and turns.

A drive at X_T(t) pulls the slider at X by a spring; contacts pull it back by F, which depends on the motion so far. At
each time forces balance, and the number of contacts is conserved:

    K (X_T - X) = F,        [share that holds] + [share that is out] = 1.

Files, to be read in this order; of each the equation that it is about. The first six carry the method.

    groups.py        contacts born together at a stretch      F = sum over groups of weight * [force of one]
    breaks.py        births follow from breaks                J(t) = B(t - delay)
    contacts.py      where a step leads all contacts          kept + survival (J - J_0) + B - J = 1, and so B, J, F
    steps/           a step at whose end forces balance       I = K (X_T - X) - F = 0 for its part in time τ
    slider.py        step by step, and slip after slip        from one section of the drive to the next
    slip_begins.py   no longer step takes more time           dτ/ds = 0
    slip_ends.py     the next balance in no time              K (X_T - X) = F at one X_T
    decohered.py     what long slips lead to                  stretches are distributed by S(x)/<x_s>
    creep.py         on to the path's end without steps       K (X_T - X) = F_k(V)
    refining.py      all of this with steps 1, 1/2, 1/4 ...   until the error is within the tolerance
    answer/          the limit of steps 0, and its error      F = F_2 + (F_2 - F_1)/3 of the last two
    unresolved.py    errors that finer steps do not show
    idle_heat.py     heat that is too weak for steps to see, and left out

How many of a group still hold is the part of its memory, one of these:

    memory.py            thresholds that stay, without heat         S(largest |x|), S the survival function of x_s;
                         or with it by their mean rate              e^-(integral of the mean rate) ("paper")
    threshold_cells.py   the same with heat                         mean over x_s of e^-A, A = integral of h dt
    changing.py          thresholds that grow; those that age       e^-H, H the largest hazard so far; sum over cells
    own_laws/            what laws of one's own state               S(largest threshold met); E of a life
    cells.py             the density of thresholds that age         du/dt = d/dy [(D U' + d|x|/dt) u + D du/dy] - h u

`cells_kernel.py` and `threshold_cells_kernel.py` are what numba compiles of these. A plain twin, in one page, of
thresholds that stay or grow, with heat and a delay, and of resets is `tests/plain_in_time.py`: who reads that first
knows what is computed here.

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
contacts form again on the way ("instant"), after it ("reform-after"; both `slip_ends.py`), or whether all are
replaced ("reset", `Slider.slip`). With a delay "instant" is "reform-after": a slip takes no time, so that no delay
ends in it. Steps go from one to the next section of the drive's motion, which end where it turns, changes speed or
holds, where the rate of births jumps one delay after such an instant, and bends two delays after it, at slips, and
where births jump a delay after these (`Slider`). After each slip that leaves all contacts new the slider does the
same again, as long as the drive keeps its speed: that is solved once (`Slider._repeat_while_new`).

Order of calls: `solve_soft` (soft/solution.py); `refined`, which for each halving makes a Memory and the contacts,
and calls `Slider.run`; there, at each begin of a section, `Slider.begin_section`, behind which nothing is drawn
through steps before it; then for each step `SlipBegins.up_to_slip`, which asks for many trials, and
`ContactsInSteps.take` of the one that is chosen. What changes the contacts: `take`; a slip (`Slider.slip`,
slip_ends.py); births that are due at once, as a slip's are one delay later (`form_due`); `repeat`, as many slips are
done at once; and `Slider._crept_to_end`, which moves X, F and the time to the path's end and leaves the groups as
they are, as no step follows. In a slip contacts are changed first; X, or the slip's list, follows from their force.

Clocks: all times here are on the path, from t = 0 on, `ContactsInSteps.now` and ends of trials, too (legs of a rigid
slider have clocks of their own, those of a soft one have not). Sizes (`Node.sizes_so_far`) and time units
(`TimeUnits`) are counted from the begin of a section; breaks and births from t = 0 or the last slip that replaced all
contacts.

Signs: X, F, stretches and `Trial.travel` are above 0 along X. Sizes, `Steps.travelled`, imbalances and all of
`SlipSoFar` are above 0 along the slider's motion, whose sign is `Steps.sign`: that of the drive, or that of the
spring's pull where the slider creeps the other way.

Refinement (`refined`): the whole path is solved with steps halved each time. Meshes of records get finer with them,
each in its own measure (`cell_edges`: twice the cells at each of the first four halvings, then at every second one).
Errors fall as the square of the steps: the last two solutions give the limit, and the changes of three an error, to
which those of the memory, rounding and what steps cannot resolve (`Unresolved`) are added (`extrapolated`). Where
that is above the tolerance the message names the largest of these parts (`Followed.why_above`).

Tests: tests/test_plain_in_time.py for parts by themselves, each memory and the plain twin, in seconds;
test_soft_laws.py and test_any_spring.py for slips. A delay: test_births_follow_from_the_breaks_one_delay_before, the
plain twin; slips: test_contacts_that_break_in_a_slip_wait_out_their_delay.
"""
