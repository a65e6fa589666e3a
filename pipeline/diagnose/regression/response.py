"""How a vehicle answers to force, learned from its sound runs, and what other runs say of it.

What a run leaves, seen along the signature of each direction, tells how much it differs. It is kept
as long as the run is: a change is added to what is known at one size after the other.
"""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from weakref import WeakKeyDictionary

import numpy as np

from pipeline.diagnose.regression.claimed import Late
from pipeline.diagnose.regression.grid import CHANNELS, STEP, GridRun
from pipeline.diagnose.regression.ridge import Fit, Ridge
from pipeline.diagnose.regression.signatures import Rows, features
from pipeline.diagnose.regression.told import BESIDE, Told
from pipeline.types import FloatArray, IntArray

#: Size, in units, at which an error of the DVL is taken that has none of its own.
_SLIGHTLY = 0.1
#: Features that say less than this share of the largest one are no dimension of their own.
_RANK = 1e-4
#: Rows for each feature without which a rest tells nothing of noise.
_ROWS = 2


@dataclass(frozen=True)
class _White:
    """One channel, filtered and over its noise.

    Directions (k, d), features (k, f), remainder (k,), features times directions (f, d), and what
    the features are told to (f, f).
    """

    directions: FloatArray
    features: FloatArray
    rest: FloatArray
    across: FloatArray
    inner: FloatArray

    @cached_property
    def basis(self) -> FloatArray:
        """Orthonormal basis (k, n) of the features."""
        vectors, values, _ = np.linalg.svd(self.features, full_matrices=False)
        return np.asarray(vectors[:, values > _RANK * values[0]])


@dataclass(frozen=True)
class _Seen:
    """A run beside what is predicted of it.

    `left` (k, c) is what is not predicted, `gained` (k, c) what velocities are predicted to gain
    over a period, `signature` (k, d, c) the change of the next velocities by a unit of each
    direction, `told` what follows of them.
    """

    rows: Rows
    predicted: FloatArray
    gained: FloatArray
    left: FloatArray
    noise: FloatArray
    white: tuple[_White, ...]
    signature: FloatArray
    told: Told


class Response(Ridge):
    """The learned response of a vehicle; see `Ridge` for its parameters."""

    @cached_property
    def _known(self) -> WeakKeyDictionary[GridRun, dict[int | None, _Seen]]:
        return WeakKeyDictionary()

    def told_of_sound(self) -> list[Told]:
        """Return what each sound run says of the directions when the others predict it."""
        return [self._seen(run, k).told for k, run in enumerate(self.runs)]

    def told(self, run: GridRun) -> Told:
        """Return what a run that took no part says of the directions."""
        return self._seen(run).told

    def settled(self, run: GridRun, change: FloatArray) -> GridRun:
        """Return a run, without directions at sizes, that moves as a change has it.

        What a heavier vehicle resists is the acceleration that there is, not that which would be
        without the change: one that a shifted centre of gravity holds at a list does not begin to
        right itself.

        Parameters
        ----------
        run : GridRun
            The run, with all directions of the change.
        change : ndarray, shape (d,)
            Size of each direction.
        """
        rows, first, left = self.after(run, change)
        made = np.zeros_like(run.velocity)
        made[rows] = first - left
        return replace(run.unsettled, made=made, settled_of=run.unsettled)

    def would_tell(self, run: GridRun) -> Told:
        """Return what a run that was not flown yet would say, with the noise of the sound ones."""
        usual = np.mean([np.mean(self._noise(one), axis=0) for one in self.remainders], axis=0)
        return self._see(run, None, usual).told

    def after(
        self, run: GridRun, changed: FloatArray, *, left_out: int | None = None
    ) -> tuple[IntArray, FloatArray, FloatArray]:
        """Predict the next velocities of a run, without and with a change.

        Parameters
        ----------
        run : GridRun
            The run.
        changed : ndarray, shape (d,)
            Size of each direction.
        left_out : int, optional
            Which sound run it is, if it is one.

        Returns
        -------
        tuple of ndarray
            Rows of the grid (k,), remainders without and with the change (k, c).
        """
        seen = self._seen(run, left_out)
        # a sound run has not the directions of changes that were asked of others
        own = changed[: seen.signature.shape[1]]
        return seen.rows.rows, seen.left, seen.left - np.einsum("kdc,d->kc", seen.signature, own)

    def explained(
        self, run: GridRun, changed: FloatArray, *, left_out: int | None = None
    ) -> tuple[FloatArray, FloatArray, FloatArray]:
        """Tell what motion and force explain of what a change leaves, as no noise does.

        Parameters
        ----------
        run, changed, left_out
            See `after`.

        Returns
        -------
        tuple of ndarray, shape (c,)
            Mean square, each over its degrees of freedom, of what they explain of it, of the rest,
            and of what they explain of the change; not a number for runs too short to tell.
        """
        found = np.zeros((3, len(self.channels)))
        for c, own in enumerate(self._seen(run, left_out).white):
            did = own.directions @ changed[: own.directions.shape[1]]
            left = own.rest - did
            basis, count = own.basis, own.basis.shape[1]
            within = float(np.sum((basis.T @ left) ** 2))
            rest = len(left) - count if len(left) >= _ROWS * count else np.nan
            found[:, c] = (
                within / count,
                max(float(left @ left) - within, 1e-24) / rest,
                float(np.sum((basis.T @ did) ** 2)) / count,
            )
        return found[0], found[1], found[2]

    def next_of(
        self, left_out: int | None, velocity: Sequence[FloatArray], run: GridRun, rows: IntArray
    ) -> FloatArray:
        """Predict next velocities (k, c) with a run left out.

        Parameters
        ----------
        left_out : int or None
            Which sound run takes no part, if one.
        velocity : sequence of ndarray, shape (k, c)
            Now and a period before.
        run : GridRun
            The run that attitude and wrench are those of.
        rows : ndarray, shape (k,)
            Rows of it that are predicted.
        """
        return self._next(self._fit_of(left_out), velocity, run, rows)

    @property
    def force(self) -> FloatArray:
        """Change of the next velocities (FORCES * 6, c) by a newton in each of the last periods.

        Along the axes that move them: what was learned along others is noise, and what a change
        seems to do there would be taken for information.
        """
        return self._force + self._learned_force(self._of_all.slope)

    def _fit_of(self, left_out: int | None) -> Fit:
        return self._of_all if left_out is None else self._left_out[left_out]

    def _seen(self, run: GridRun, left_out: int | None = None) -> _Seen:
        own = self._known.setdefault(run, {})
        if left_out not in own:
            own[left_out] = self._see(run, left_out)
        return own[left_out]

    def _see(self, run: GridRun, left_out: int | None, usual: FloatArray | None = None) -> _Seen:
        """Weigh what a run leaves along its directions, with its own noise or the `usual` (c,)."""
        fit = self._fit_of(left_out)
        if run.base is not None:
            base = self._seen(run.base, left_out) if usual is None else None
            return self._with(base or self._see(run.base, left_out, usual), run.added, run, fit)
        if run.settled_of is not None and usual is None:
            before = self._seen(run.settled_of, left_out)
            bare = replace(
                _without_directions(before), gained=before.gained + _made(run, before.rows.rows)
            )
            return self._told_by(bare, self._resettled(before, run, fit), run)
        one = Rows(run, self._mean)
        x = self._scaled(one)
        predicted = one.mean + x @ fit.slope
        left = one.next - predicted
        noise = self._noise(left) if usual is None else np.broadcast_to(usual, left.shape)
        every = len(self.channels) + BESIDE
        none = np.zeros((every, 0, 0)), np.zeros((every, 0)), np.zeros(0)
        bare = _Seen(
            rows=one,
            predicted=predicted,
            gained=self._gained(one, fit, predicted) + _made(run, one.rows),
            left=left,
            noise=noise,
            white=tuple(self._white(c, fit, x, left, noise) for c in range(len(self.channels))),
            signature=np.zeros((len(left), 0, left.shape[1])),
            told=Told(*none),
        )
        return self._with(bare, run, run, fit)

    def _resettled(self, before: _Seen, run: GridRun, fit: Fit) -> FloatArray:
        """Signatures (k, d, c) of a run whose velocities gain more than was predicted before."""
        found, rows = before.signature.copy(), before.rows
        heavy = np.flatnonzero(np.any(run.heavier, axis=(1, 2)))
        force, made = self._learned_force(fit.slope), _made(run, rows.rows)
        found[:, heavy] += rows.signatures(run.of_directions(heavy), force, made)
        return found

    def _gained(self, one: Rows, fit: Fit, predicted: FloatArray) -> FloatArray:
        """Return what velocities are predicted to gain over a period (k, c).

        Noise of a reading now stands in what is predicted from it, and in what that leaves: in slow
        runs all vehicles would seem lighter. Where accelerations tell the course, it is of that.
        """
        course = one.run.course
        if course is None:
            return predicted - one.now
        now, before = course[one.rows - 1], course[one.rows - 2]
        return self._next(fit, (now, before), one.run, one.rows) - now

    def _white(
        self, channel: int, fit: Fit, x: FloatArray, left: FloatArray, noise: FloatArray
    ) -> _White:
        both = self._whitened(np.column_stack([x, left[:, channel]]), channel, noise)
        own, rest = both[:, :-1], both[:, -1]
        inner = np.linalg.inv(np.linalg.inv(fit.covariance[channel]) + own.T @ own)
        none, across = np.zeros((len(x), 0)), np.zeros((own.shape[1], 0))
        return _White(none, own, rest, across, np.asarray(inner))

    def _with(self, seen: _Seen, asked: GridRun, run: GridRun, fit: Fit) -> _Seen:
        """Add the directions of `asked`; then they are those of the `run`."""
        return self._told_by(seen, self._signatures(seen, asked, fit), run)

    def _told_by(self, seen: _Seen, new: FloatArray, run: GridRun) -> _Seen:
        """Add signatures (k, d, c), with which the directions are those of the `run`.

        Errors of the slopes are integrated out.
        """
        count = seen.told.thrust.size
        every = count + new.shape[1]
        information = np.zeros((len(seen.told.by_channel), every, every))
        score = np.zeros((len(information), every))
        information[:, :count, :count] = seen.told.by_channel
        score[:, :count] = seen.told.score_by_channel
        white = []
        for c, own in enumerate(seen.white):
            more = self._whitened(new[:, :, c], c, seen.noise)
            both = np.hstack([own.directions, more])
            gone = own.features.T @ more
            across = np.hstack([own.across, gone])
            lost = gone.T @ own.inner
            information[c, count:] = more.T @ both - lost @ across
            information[c, :count, count:] = information[c, count:, :count].T
            score[c, count:] = more.T @ own.rest - lost @ (own.features.T @ own.rest)
            white.append(replace(own, directions=both, across=across))
        for k, (told, slope) in enumerate(run.beside, start=len(self.channels)):
            information[k], score[k] = told, slope
        return replace(
            seen,
            white=tuple(white),
            signature=np.concatenate([seen.signature, new], axis=1),
            told=Told(information, score, _thrust(run)),
        )

    def _signatures(self, seen: _Seen, asked: GridRun, fit: Fit) -> FloatArray:
        """Change of the next velocities (k, d, c) by a unit of each direction that is asked."""
        force = self._learned_force(fit.slope)
        found = seen.rows.signatures(asked, force, seen.gained)
        if asked.late:
            more = asked.more.copy()
            for k, late in asked.late.items():
                more[:, k] = late.wrench
            of_rates = seen.rows.signatures(replace(asked, more=more), force, seen.gained)
            found[:, list(asked.late), 3:] = of_rates[:, list(asked.late), 3:]
        found += self._misread(seen, asked, fit)
        for k, late in asked.late.items():
            found[:, k, 3:] += self._by_then(seen, late, fit) / asked.taken.get(k, STEP)
        return found

    def _by_then(self, seen: _Seen, late: Late, fit: Fit) -> FloatArray:
        """Change (k, 3) of next rates: they follow of the velocity that is true, not as it is read.

        Both without the noise of readings, which stands in what these leave of the rates.
        """
        run, rows = seen.rows.run, seen.rows.rows

        def following(linear: FloatArray) -> FloatArray:
            both = np.hstack([linear, run.velocity[:, 3:]])
            return self._next(fit, (both[rows - 1], both[rows - 2]), run, rows)[:, 3:]

        return following(late.true) - following(late.read)

    def _misread(self, seen: _Seen, asked: GridRun, fit: Fit) -> FloatArray:
        """Change (k, d, c) of what is read of a unit: next, less what follows of it now and before.

            E x(t + T) - [f(x(t), x(t - T)) - f(x(t) - E x(t), x(t - T) - E x(t - T))]

        with x velocities and rates. Velocities are what is predicted from those now: their noise
        then takes itself off, while that of readings to come would pass for motion. Rates are no
        readings of them, and what a velocity now does to these is that of one predicted before:
        the noise of a reading stands in what it leaves of the rates, too. An error of the mount
        turns a fast vehicle's speed into a drift whose drag is not in proportion to it: it is taken
        at its size.
        """
        run, rows, ahead = seen.rows.run, seen.rows.rows, seen.predicted
        found = np.zeros((rows.size, len(asked.misread), len(self.channels)))
        none = np.zeros((len(run.velocity), 3))
        own = {*np.flatnonzero(np.any(asked.misread, axis=(1, 2))).tolist(), *asked.late}
        if not own or self.channels != CHANNELS:
            return found
        before, now = run.velocity[rows - 2], seen.rows.now
        to_come = np.hstack([ahead[:, :3], run.velocity[rows, 3:]])
        expected = now.copy()
        expected[1:, :3] = ahead[:-1, :3]
        as_expected = self._next(fit, (expected, before), run, rows)
        for k in own:
            size = asked.taken.get(k, _SLIGHTLY)
            turned = size * asked.misread[k].T
            slip = size * (asked.late[k].slip if k in asked.late else none)
            linear = [
                _without(one, one @ turned + slip[at])
                for one, at in ((now, rows - 1), (before, rows - 2))
            ]
            follows = ahead - self._next(fit, linear, run, rows)
            found[:, k, :3] = (to_come @ turned + slip[rows] - follows[:, :3]) / size
            likely = [_without(one, one @ turned) for one in (expected, before)]
            follows = as_expected - self._next(fit, likely, run, rows)
            found[:, k, 3:] = -follows[:, 3:] / size
        return found

    def _next(
        self, fit: Fit, velocity: Sequence[FloatArray], run: GridRun, rows: IntArray
    ) -> FloatArray:
        now, before = velocity
        scaled = (features(now, before, run, rows) - self._middle) * self._scale
        return self._mean(now, before, run, rows) + scaled @ fit.slope


def _without(state: FloatArray, misread: FloatArray) -> FloatArray:
    """Velocities and rates (k, 6) without what is misread of the linear ones (k, 3)."""
    return np.hstack([state[:, :3] - misread, state[:, 3:]])


def _made(run: GridRun, rows: IntArray) -> FloatArray:
    """Change (k, c) of the next velocities by what a run is settled by."""
    return np.zeros((rows.size, run.velocity.shape[1])) if run.made is None else run.made[rows]


def _without_directions(seen: _Seen) -> _Seen:
    every, told = slice(0, 0), seen.told
    white = [
        replace(one, directions=one.directions[:, every], across=one.across[:, every])
        for one in seen.white
    ]
    none = Told(
        told.by_channel[:, every, every], told.score_by_channel[:, every], told.thrust[every]
    )
    return replace(seen, white=tuple(white), signature=seen.signature[:, every], told=none)


def _thrust(run: GridRun) -> FloatArray:
    """Share (d,) by which a unit of each direction changes the thrust of a run."""
    power = np.mean(run.wrench**2, axis=0)
    moved = power > max(1e-6 * float(power.max()), 1e-12)
    along = np.mean(run.more * run.wrench[:, None], axis=0)[:, moved] / power[moved]
    return np.asarray(along.sum(axis=1) / max(int(moved.sum()), 1))
