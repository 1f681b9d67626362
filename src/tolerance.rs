//! Every rounding, margin and threshold that decides an outcome, once, with its unit and its reason. Two kinds of constants stand where
//! they are used, with a mark in their documentation: `[work]` bounds or divides work, so that with another value an answer is the same
//! or missing; `[exact]` leaves no choice, being a number of mathematics, of a tableau, of a format or of a unit.

// --- Rounding of what is computed, in parts of the size of its terms unless something else is said.

/// A wider rounding of a gap, of speeds and accelerations, relative to the size of their terms; touches are told from impacts by
/// [`TERM_ROUNDINGS`].
pub(crate) const GAP_ROUNDING: f64 = 1e-14;
/// The margin between graze and impact: a minimum of a gap no farther below zero than this part of the size of its terms is a touch
/// (theory 8).
pub(crate) const TERM_ROUNDINGS: f64 = 16.0 * f64::EPSILON;
/// The same relative to the sum of the sizes of all parts of the motion in it, where the rows are as good.
pub(crate) const SUM_ROUNDINGS: f64 = 4.0 * f64::EPSILON;
/// What is left of terms of a sum below this part of their sizes is rounding.
pub(crate) const CANCELLED: f64 = 1e-14;
/// Rounding of the terms of a gap where its state was taken from a position.
pub(crate) const PLACED_ROUNDING: f64 = 4.0 * f64::EPSILON;
/// Rounding of a gap or a speed at the start.
pub(crate) const GIVEN_ROUNDING: f64 = 4.0 * f64::EPSILON;
/// Rounding of the time of a flight, in which a gap moves on by its speed.
pub(crate) const TIME_ROUNDING: f64 = 4.0 * f64::EPSILON;
/// Rounding of a speed, relative to that of a fall as far as the motion goes.
pub(crate) const SPEED_ROUNDING: f64 = 10.0 * GAP_ROUNDING;
/// Rounding of a difference of accelerations, relative to the size of their terms.
pub(crate) const JERK_ROUNDING: f64 = 10.0 * GAP_ROUNDING;
/// Impulses of so small a part of the largest at one instant are rounding.
pub(crate) const IMPULSE_ROUNDING: f64 = 1e-12;
/// Rounding of a sum of a few products, relative to the size of its terms.
pub(crate) const IMPACT_ROUNDING: f64 = 8.0 * f64::EPSILON;
/// Rounding of a sum, relative to its terms, and of the angle between opposite normals.
pub(crate) const ROOM_ROUNDING: f64 = 8.0 * f64::EPSILON;
/// A value of a search by values this small, where they are of order one, is rounding.
pub(crate) const VALUE_ROUNDING: f64 = 1e-13;
/// The ends of neighbouring cells are one place but for this part of the ends of the interval.
pub(crate) const SAME_PLACE: f64 = 4.0 * f64::EPSILON;
/// Rounding of a motion that grows, in units of its growth over a flight.
pub(crate) const CLOSING_ROUNDING: f64 = 1e3 * f64::EPSILON;
/// Rounding of a determinant, relative to the sum of its products' sizes.
pub(crate) const FLIGHT_TIME_ROUNDING: f64 = 64.0 * f64::EPSILON;
/// Rounding up to which planes are at one place.
pub(crate) const ONE_PLACE: f64 = 4.0 * f64::EPSILON;
/// Units in the last place by which the entries of a matrix that was assembled from few parts are off.
pub(crate) const ENTRY_ROUNDINGS: f64 = 4.0;

/// The absolute tolerance of a run that gives none, in parts of how far the motion goes.
pub(crate) const ABSOLUTE_PART: f64 = 1e-12;

/// A function is given by polynomials up to this part of its largest value.
pub(crate) const FUNCTION_TOL: f64 = 1e-14;
/// Polynomials that a function is given by, at the most.
pub(crate) const MOST_PIECES: usize = 1_000_000;
/// The motion of a stop may jump by this part of its largest value, and its slope by this part of the largest slope: rounding.
pub(crate) const SMOOTH_MOTION: f64 = 1e-9;
/// A frequency is a whole multiple of another up to this part of itself.
pub(crate) const WHOLE_MULTIPLE: f64 = 1e-12;

// --- Dependence, rank and symmetry of matrices and directions.

/// Singular values below this part of the largest entry of a matrix of directions, or of their products, are zero: the
/// directions depend on each other.
pub(crate) const DEPENDENT: f64 = 1e-12;
/// Pivots up to this, relative to the scaled matrix, are rounding: its columns are dependent.
pub(crate) const DEPENDENT_ACTIVE: f64 = 1e-14;
/// Ratios that differ by no more than this are tied.
pub(crate) const TIE_TOL: f64 = 1e-12;
/// Asymmetry up to which a matrix counts as symmetric, relative to the largest entries of the two rows, of the smaller of them: that
/// of a penalty elsewhere says nothing.
pub(crate) const SYMMETRY_TOL: f64 = 1e-12;
/// Where no pivot of a Delassus matrix is below this part of the largest, elimination is as good as singular values, and leaves
/// alone what does not depend on the rest.
pub(crate) const SAFE_PIVOT: f64 = 1e-8;
/// A product of a reaction direction and a free direction below this, relative to both, is zero.
pub(crate) const ORTHOGONAL_TOL: f64 = 1e-12;
/// Relative deviation of a given recovery matrix that counts as rounding.
pub(crate) const AUDIT_TOL: f64 = 1e-9;

// --- Modes and flows.

/// An off-diagonal entry of the modal damping below this, relative to the larger of the two modes' own entries, or to the sizes of
/// its terms, is rounding.
pub(crate) const PROPORTIONAL_TOL: f64 = 1e-12;
/// Ratio of the squared frequencies `K_ii/M_ii` of two coordinates alone beyond which errors relative to the largest eigenvalue would
/// take four digits of the smallest.
pub(crate) const GRADED: f64 = (1u64 << 13) as f64;
/// The same beyond which no digits are left where the modes are complex: their vectors have errors of the root of it.
pub(crate) const TOO_GRADED: f64 = 1.0 / f64::EPSILON;
/// Imaginary parts below this, relative to the largest root, are rounding.
pub(crate) const REAL_ROOT_TOL: f64 = 1e-12;
/// Condition number of a root above which the matrix counts as defective: the modes lose that factor of the digits, the
/// matrix exponential does not.
pub(crate) const DEFECTIVE_CONDITION: f64 = 1e3;
/// Roots below this part of the largest are zero.
pub(crate) const ZERO_ROOT: f64 = 1e-12;
/// Roots between that and this part of the largest are a double one at zero, of a body that nothing holds, which rounding has
/// split: their vectors are known to half the digits.
pub(crate) const SPLIT_ZERO_ROOT: f64 = 1e-7;
/// Real roots below this part of the largest are zero but for rounding: what moves along them stays where it is.
pub(crate) const STANDS_STILL: f64 = 1e-14;
/// A resonance is near where `|(i w - l_1)(i w - l_2)|` is below this times `w^2 + |l_1 l_2|`: the steady response and the
/// free motion would cancel in more than two digits.
pub(crate) const NEAR_RESONANCE: f64 = 1e-2;
/// Roots below this part of the fastest are those of a rigid body, which slow forcing moves along whatever its motion is: its
/// steady response has no scale of its own.
pub(crate) const RIGID: f64 = 1e-9;
/// The distance in q, in units of the coordinates, within which an equilibrium counts as the one at q = 0.
pub(crate) const EQUILIBRIUM_TOL: f64 = 1e-12;
/// Part of its size by which an entry of a given derivative may differ from a difference.
pub(crate) const WRONG_JACOBIAN: f64 = 1e-3;
/// Error of a difference, relative to the largest entry of its column.
pub(crate) const ROUGH_JACOBIAN: f64 = 1e-6;

/// Part of their sizes by which differences of an acceleration to both sides may differ unless a shorter step is asked: the mean of both is
/// then off by the square of that.
pub(crate) const BENT: f64 = 1e-4;
/// Part of their sizes up to which differences of two lengths are the same: what `BENT` makes of them.
pub(crate) const SAME_DIFFERENCE: f64 = 1e-8;
/// Part of their sizes above which differences of no two lengths agree: of the longer, on a rough function, a sixteenth of that is not known.
pub(crate) const DOUBTFUL: f64 = 1e-4;
/// Part of its size to which a deviation is known whose acceleration is a difference.
pub(crate) const DEVIATION_KNOWN: f64 = 1e-10;
/// The smallest part of a motion as which deviations are carried beside it.
pub(crate) const SMALLEST_DEVIATION: f64 = 1e-6;
/// Part of the change of an acceleration across a step that lies in one half of it where it is not smooth there; along a power of the time
/// as high as the order of a method twice in a row.
pub(crate) const ONE_SIDED: f64 = 0.9;
/// Changes of an acceleration up to this part of its largest value are no jumps that count.
pub(crate) const JUMP: f64 = 1e-9;
/// How often in a row the change lies in one half where an acceleration jumps.
pub(crate) const JUMP_HALVINGS: usize = 6;

// --- Contacts along a flight, and what happens at one instant.

/// Touches nearer to each other than this part of the step are one.
pub(crate) const SAME_TOUCH: f64 = 1e-6;
/// The quartic through a contact force is off by no more than this, relative to the force.
pub(crate) const FORCE_TOL: f64 = 1e-4;
/// A contact force at zero: this small, relative to its terms.
pub(crate) const FLAT_FORCE: f64 = 1e-12;
/// Two impact speeds in succession are in the ratio e within this, where impacts accumulate.
pub(crate) const RATIO_TOL: f64 = 0.05;
/// What is left of accumulating impacts is up to so many times its estimate.
pub(crate) const CHATTER_SAFETY: f64 = 4.0;
/// A flight that rises by no more than so many roundings of the gap has lost the digits of its speed.
pub(crate) const LOST_FLIGHT: f64 = 2.5;
/// Flights that rise by fewer times what is left below zero are low.
pub(crate) const MOST_SUNK: f64 = 1e4;
/// Roundings of a gap that are left of it, at the most, where steps have reached its stop.
pub(crate) const MOST_LEFT: f64 = 100.0;
/// An estimate of the error of an interpolation is off by no more than this factor.
pub(crate) const ERROR_FACTOR: f64 = 4.0;
/// A normal and a reaction direction whose product is below this part of theirs do not see each other.
pub(crate) const UNCOUPLED: f64 = 1e-12;
/// Part of a speed by which an impact's row and the motion after it may differ.
pub(crate) const AGREED: f64 = 1e-9;
/// Times less apart than this part of them are one instant.
pub(crate) const INSTANT: f64 = 1e-12;
/// Acceleration of a gap, relative to the largest terms of those in contact, that the time of its release may leave of none; in
/// steps that of another's too.
pub(crate) const RELEASED: f64 = 1e-9;
/// Third derivatives of gaps, had by differences, are zero below this part of what others do to them.
pub(crate) const STEADY_BY_STEPS: f64 = 1e-6;
/// Roundings of a gap up to which those held may keep it closed, if not the absolute tolerance.
pub(crate) const FACING: f64 = 4.0;

// --- What motions settle on.

/// A motion this many boxes away from its box has left it.
pub(crate) const FAR: f64 = 1e3;
/// States nearer to each other than this part of the motion are one: what repeats itself does so to this, orbits are one whose states are,
/// and an advance of less is none. What motions are integrated to by default lies far below it.
pub(crate) const SAME_STATE: f64 = 1e-6;
/// Two sets are one if this part of the nearest neighbours of a state of either is the other's, or more: half of them are, but for chance
/// and for motions that stay in a part for long.
pub(crate) const SHARED_MANY: f64 = 0.25;
/// They are two if less than this part is.
pub(crate) const SHARED_FEW: f64 = 0.01;
/// A state is on a set if its nearest neighbour there is no farther than so many times that of the set's own points, their median.
pub(crate) const IN_SET: f64 = 4.0;

/// What comes from a file agrees with its scene within this part of the sizes of its terms: far more than the tolerances of any run
/// leave, and than the numbers of another scene do.
pub(crate) const KEPT_AGREES: f64 = 1e-2;

// --- Orbits.

/// What is left of the gap when an orbit takes the rest of its impacts at once, relative to the motion's size: below what it
/// closes to. In runs the tolerances decide.
pub(crate) const CHATTER_DEPTH: f64 = 2.5e-13;
/// How far from the unit circle a single point may be and count as on it: rounding alone.
pub(crate) const ON_CIRCLE: f64 = 1e-12;
/// The same for a double root, a fold: below the 1e-12 that must still be told apart.
pub(crate) const AT_FOLD: f64 = 8.0 * f64::EPSILON;
/// Phases [rad] nearer to each other than this are one, found in cells on both sides of it.
pub(crate) const SAME_PHASE: f64 = 1e-11;
/// Least part of the direction that moves the phase.
pub(crate) const CLEAR_DIRECTION: f64 = 1e-6;
/// Least singular value of the two rows, in units of order one, below which the decomposition decides instead; far
/// above the tolerance of the rank.
pub(crate) const CLEAR_RANK: f64 = 1e-4;
/// Residual of the conditions, each in units of its own terms, up to which they agree.
pub(crate) const CONSISTENT: f64 = 1e-11;
/// Singular values of the periodic conditions below this, relative to the largest, are zero (theory 5).
pub(crate) const CONDITIONS_RANK: f64 = 1e-10;
/// A mode whose `det(I - e^{A T})` is below this, relative to its size, keeps its two unknowns.
pub(crate) const RETAIN_BELOW: f64 = 1e-4;
/// Misfit, relative to the unknowns, of a root.
pub(crate) const CONVERGED: f64 = 1e-11;
/// A smallest singular value below this, relative to the largest, leaves two starts.
pub(crate) const NEARLY_SINGULAR: f64 = 1e-4;
/// How far from an undecided stretch its roots may be, relative to T.
pub(crate) const NEAR_FLIGHT_TIME: f64 = 1e-8;
/// Two roots this close, relative to T, and in phase, are one.
pub(crate) const SAME_FLIGHT_TIME: f64 = 1e-9;
/// Misfit of further contacts, relative to the unknowns, up to which stops are hit together.
pub(crate) const TOGETHER: f64 = 1e-9;
/// A flight time this close to a trivial one, relative to T, is that one: far below, rounding rules.
pub(crate) const TRIVIAL_FLIGHT: f64 = 1e-6;
/// Part of the range that may stay undecided before the outcome says so first.
pub(crate) const UNDECIDED_PART: f64 = 0.01;
/// Residual of the repetition of a motion above which there is none.
pub(crate) const SOLVABLE: f64 = 1e-11;
/// A row's entries of a mode below this, relative to its largest, are rounding.
pub(crate) const UNSEEN: f64 = 1e-13;
/// Entries that vanish by symmetry are below this, relative to their terms.
pub(crate) const SPLIT_ROWS: f64 = 1e-13;
/// Largest scaled mismatch of what counts as closed.
pub(crate) const ORBIT_CLOSED: f64 = 1e-11;
/// The same of flights that are integrated: steps of 2e-13 each leave this much of some thousand, where kinks and jumps of a force make their
/// errors those of other steps for every start.
pub(crate) const ORBIT_CLOSED_BY_STEPS: f64 = 5e-11;
/// Rounds of a loop are one if it closes after the first to this part of its size.
pub(crate) const SAME_ROUND: f64 = 1e-8;
/// An orbit that misses closing by more than this, in its own size, is not one of the scene.
pub(crate) const ELSEWHERE: f64 = 1e-6;
/// Singular values below this, relative to the largest entry, belong to directions in which the orbit may be changed.
pub(crate) const FREE_DIRECTION: f64 = 1e-12;
/// The same of integrated flights, whose errors change with what they begin with: along weaker ones a loop is corrected only where it comes
/// no nearer to closing otherwise.
pub(crate) const WEAK_DIRECTION: f64 = 1e-8;
/// What a period later may differ, relative to the acceleration.
pub(crate) const REPEATS: f64 = 1e-9;
/// A return as near as this, relative to the motion's size, is one; of a trajectory that has not settled so far the
/// nearest return is taken.
pub(crate) const RETURNED: f64 = 0.05;
/// A state this small, relative to the motion, is one of rest: its rounding says nothing.
pub(crate) const AT_REST: f64 = 1e-9;
/// What an orbit misses its own beginning by, relative to its size, at the most: 1e-9 in any norm.
pub(crate) const FLIGHTS_CLOSED: f64 = 3e-10;
/// Margin within which a gap counts as touching, relative to the motion's size along the normal: what rounding makes of an
/// orbit's position, with room to spare.
pub(crate) const ORBIT_MARGIN: f64 = 2e-13;
/// Margin within which a gap counts as touching, relative to the motion's size: what the flights are known to.
pub(crate) const INTEGRATED_MARGIN: f64 = 1e-10;
/// Margin of a contact force, relative to the size of its terms: at a release it is zero to what the orbit closes to.
pub(crate) const FORCE_MARGIN: f64 = 1e-10;
/// Margins within which a flight between two contacts is a low one; a search that starts on the stop cannot tell it from a touch.
pub(crate) const LOW_BOUNCE: f64 = 100.0;
/// A largest modulus this close to 1 decides nothing.
pub(crate) const MARGINAL: f64 = 1e-9;
/// Multipliers that meet are known to this, the root of what one is known to.
pub(crate) const MEETING: f64 = 1e-6;
/// Rounding of a sum of flights against the periods of the forcing, relative.
pub(crate) const PERIOD_TOL: f64 = 1e-6;
/// Rounding of a time counted in periods, relative to the largest of a run.
pub(crate) const TIME_TOL: f64 = 1e-9;
/// Relative difference of two depths above which a rough error does not change their order.
pub(crate) const DISTINCT: f64 = 1e-2;
/// Relative error of the depth of a violation that is good enough to tell two of them apart.
pub(crate) const ROUGH_MULTIPLIER: f64 = 1e-3;
/// Extremes of a motion that differ by no more than this part of its size are reached together.
pub(crate) const SAME_EXTREME: f64 = 1e-9;
/// A gap this small, relative to the largest of its stop, without an impact, or an approach speed, relative to the motion's largest, is a
/// touch of which numbers have a derivative on one side alone: steps of a difference lead across it.
pub(crate) const TOUCHED: f64 = 1e-9;

// --- Matrices, flights and contacts: linalg, modal, impact, flow, contact, hybrid.

// --- Scenes, runs and their records: model, path, recurrence, simulate, section.

// --- Periodic motions: orbit.

// --- Deviations: derivative, exponents.

// --- Branches.

// --- Families: sweep, attractor, basin.
