"""Number conservation, written with survivals, solved panel by panel (derivation: docs/equations.md).

State: solved panels of time, on each of which the breaks B are a polynomial, and lumps, contacts born together. Births
are the breaks, one delay later. One step, of `March`:

1. `PanelWidth` proposes the width of the next panels, and how many.
2. `Past.enter` turns to the leg of these panels, if it is a new one: what was born before is then on earlier legs.
3. `March._sums_on_leg` adds up, at the nodes of these panels, number and force of all contacts whose births are known:
   `Present`, those born on the present leg, whose survival depends on the lag since birth alone; `Past`, all others,
   where survivals take long at a few of the nodes only (`FewTimes`); and those that are out.
4. `solve_batch` finds the breaks at the nodes for which number and own births add up to 1, and from them the force.
   Between the nodes the sum differs from 1: that is the error of the panel.
5. Panels within the tolerance are kept; the first that is not ends the batch, and the next ones are narrower.

An example of 3: the slider turns at t = 2, the delay is 0.3, and a panel from 2.6 to 2.8 is to be solved.

    panels with breaks from   | born from  | births are on            | who adds number and force
    1.6 to 1.7                | 1.9 to 2.0 | an earlier leg           | `Past`
    1.7 to 2.0, 2.0 to 2.2    | 2.0 to 2.5 | this leg                 | `Present.sums` and `still_out`
    2.2 to 2.4, 2.4 to 2.6    | 2.5 to 2.9 | this leg, width as below | `Present.panel_sums`
    2.6 to 2.8, to be solved  | 2.9 to 3.1 | this leg                 | `Present.panel_sums`: all are out

`Past.first_panel` is the first whose births are on this leg (here 1.7), `March._count_same_width` counts the third row,
and what broke more than a longest life and a delay ago counts for nobody (`March._oldest_that_counts`).

A delay enters where breaks become births: `SolvedPanels.births_begin` and `middle_of_births`, hence `Past`, whose
`_legs_of_births` adds it itself; where those that are out are counted: `still_out`, for `Present.panel_sums` and
`March._sums_on_leg`; in `Present.panel_sums` the births of a panel lie one delay after it; in the births of lumps
(`March._break_lumps`), in how far back contacts count (`March.longest_cycle`, `rigid.breaks_until`), and in the edges
(`edges.py`).

At an edge, where the breaks may jump, contacts that reach an exact threshold together become a lump
(`March._break_lumps`).

Times are counted from the beginning of the path, or, to keep digits, from that of a leg: their names then end in `_leg`
or `_own_leg` (past.py). Times that are asked for together stand in rows, each within one panel: on which side of a
jump at its end it lies is told by its middle (`motion.middle_of`).

The docstring of `master.solve` lists the files in the order in which they begin. To read, begin with `births.py` and
`march.py`; `past.py` leads on to births on earlier legs.

Tests: tests/test_solve.py, test_turning.py, test_panel_edges.py and test_orders_panels.py; for errors
test_force_error.py, test_unseen_errors.py and test_faults_name_themselves.py. A plain twin: `paper/renewal.py`, held
beside it by test_explicit.py. A delay: test_births_on_panels_of_many_widths_with_jumps_and_a_delay in closed form,
test_one_value_with_a_delay_is_a_sawtooth_with_gaps; turns: test_an_exact_threshold_met_just_as_the_path_turns_breaks.
"""
