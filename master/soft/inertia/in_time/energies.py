"""Energies on one step of a slider with mass, which is not taken yet."""

from master.soft.in_time.contacts import ContactsInSteps, Trial
from master.soft.inertia.in_time.node import Spent
from master.soft.inertia.in_time.swing_steps import Swung


class Energies:
    """Energies on steps of these contacts, under this spring and damping.

    Its methods take, for one step, `pull`, the spring's force minus that of the contacts as it begins (a length), and
    `drive_speed`, that of the drive on it.
    """

    def __init__(self, contacts: ContactsInSteps, spring: float, damping: float) -> None:
        self._contacts, self._spring, self._damping = contacts, spring, damping

    def on_swing(self, swung: Swung, pull: float, drive_speed: float) -> Spent:
        """On a step of a swing, whose motion is closed and along which the rest of F grows evenly."""
        contacts, trial, motion = self._contacts, swung.trial, swung.motion
        lasts, travel = trial.end - contacts.now, trial.travel
        # integral of y over the time of the step
        moved = motion.centre * lasts + 0.5 * motion.drift * lasts**2
        moved += float(motion.departure_integral(lasts))
        rate = self._spring * drive_speed
        pulled = (pull + contacts.force) * lasts + 0.5 * rate * lasts**2
        work = drive_speed * (pulled - self._spring * moved)
        damped = self._damping * float(motion.squared_speed(lasts))
        stiff = contacts.holding
        left = trial.force - contacts.force - stiff * travel
        on_contacts = contacts.force * travel + 0.5 * stiff * travel**2
        on_contacts += left * (travel - moved / lasts)
        return Spent(work, damped, on_contacts)

    def in_balance(self, trial: Trial, pull: float, drive_speed: float) -> Spent:
        """On a step in balance, on which speed and forces change evenly."""
        contacts, lasts = self._contacts, trial.end - self._contacts.now
        before = pull + contacts.force
        after = before + self._spring * (drive_speed * lasts - trial.travel)
        work = 0.5 * drive_speed * lasts * (before + after)
        on_contacts = 0.5 * (contacts.force + trial.force) * trial.travel
        return Spent(work, self._damping * trial.travel**2 / lasts, on_contacts)
