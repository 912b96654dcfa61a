"""What sliders do: those of infinitely many contacts, and those of as many as the area holds.

In reading order: `machine.py`, a slider's machine; `records.py`, what one teller says of it (`Behaviour`, `Finite`);
`follow.py`, infinitely many contacts by the master equation, driven until their slips tell what follows, mostly five;
`told.py`, what a solution says, where a behaviour gets its kind; `ways.py`, how far a slider is pulled;
`slips_in_time.py`, slips with a duration; `steady.py` and `forgetting.py`, when sliding is steady and what a slip
leaves of the past; `in_heat.py` and `weak_heat.py`, sliders in heat for which there are no steps in time;
`ensemble.py`, sliders of some contacts, whose number the time decides, beginning with a pilot of a thousand;
`late.py`, their late slips; `by_contacts.py`, what they tell, and what fewer contacts than there are change;
`plans.py`, how far the drive of finitely many contacts goes and how often they break on the way; `finite.py`, how many
of those of the area four sliders have, and rules under which these do the same; `judged.py`, which kind they are, by
their slips beyond a transient;
`islands.py`, the numbers to begin with for islands; and `budget.py`, times and numbers of breaks that all of these keep
to.
"""
