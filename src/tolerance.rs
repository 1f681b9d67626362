//! Every rounding, margin and threshold that decides an outcome, once, with its unit and its reason. Two kinds of constants stand where
//! they are used, with a mark in their documentation: `[work]` bounds or divides work, so that with another value an answer is the same
//! or missing; `[exact]` leaves no choice, being a number of mathematics, of a tableau, of a format or of a unit.

// --- Rounding of what is computed, in parts of the size of its terms unless something else is said.

/// A wider rounding of a gap, of a speed and of an acceleration, in parts of the sizes of their terms; touches are told from impacts by
/// [`TERM_ROUNDINGS`].
pub(crate) const GAP_ROUNDING: f64 = 1e-14;
/// The margin between graze and impact, of runs: a minimum of a gap no farther below zero than this part of the size of its terms is a
/// touch (theory 8, `event/touch.rs`). Of orbits it is [`ORBIT_MARGIN`] and [`INTEGRATED_MARGIN`].
pub(crate) const TERM_ROUNDINGS: f64 = 16.0 * f64::EPSILON;
/// The rounding of a gap in parts of the sum of the sizes of all parts of the motion in it, where the rows that give them are known as well
/// as that.
pub(crate) const SUM_ROUNDINGS: f64 = 4.0 * f64::EPSILON;
/// A sum below this part of the sizes of its terms is what rounding left of terms that cancel, and counts as zero.
pub(crate) const CANCELLED: f64 = 1e-14;
/// Rounding of a gap, in parts of the sizes of its terms, where the modal state was made from a position.
pub(crate) const PLACED_ROUNDING: f64 = 4.0 * f64::EPSILON;
/// Rounding of a gap or a speed of the state that a run starts from, in parts of the sizes of its terms.
pub(crate) const GIVEN_ROUNDING: f64 = 4.0 * f64::EPSILON;
/// Rounding of the time of a flight, in parts of it: a gap is unknown by its speed times that.
pub(crate) const TIME_ROUNDING: f64 = 4.0 * f64::EPSILON;
/// Rounding of a speed, in parts of the speed of a free fall over the distance that the motion goes.
pub(crate) const SPEED_ROUNDING: f64 = 10.0 * GAP_ROUNDING;
/// Rounding of a difference of two accelerations, in parts of the sizes of their terms.
pub(crate) const JERK_ROUNDING: f64 = 10.0 * GAP_ROUNDING;
/// Impulses below this part of the largest one at the same instant are rounding.
pub(crate) const IMPULSE_ROUNDING: f64 = 1e-12;
/// Rounding of a sum of a few products, in parts of the sizes of its terms.
pub(crate) const IMPACT_ROUNDING: f64 = 8.0 * f64::EPSILON;
/// Rounding of the room between two facing stops, in parts of the sizes of its terms, and of the angle between their normals [rad].
pub(crate) const ROOM_ROUNDING: f64 = 8.0 * f64::EPSILON;
/// A value of a function scaled to order one that is this small is rounding.
pub(crate) const VALUE_ROUNDING: f64 = 1e-13;
/// Ends of neighbouring intervals of a search are one point up to this part of the ends of the whole interval.
pub(crate) const SAME_PLACE: f64 = 4.0 * f64::EPSILON;
/// Rounding of where a growing motion ends, in parts of its size, divided by the factor by which it grows over its flights.
pub(crate) const CLOSING_ROUNDING: f64 = 1e3 * f64::EPSILON;
/// Times its decay constant after which the place of an element that goes back to where it was is there, to the last digit.
pub(crate) const PLACE_FORGOTTEN: f64 = 36.0;
/// Rounding of the determinant whose zeros are flight times, in parts of the sum of the sizes of its products.
pub(crate) const FLIGHT_TIME_ROUNDING: f64 = 64.0 * f64::EPSILON;
/// Two planes are one where their normals and clearances differ by no more than this part of their sizes: rounding.
pub(crate) const ONE_PLACE: f64 = 4.0 * f64::EPSILON;
/// Rounding of the entries of a matrix that was assembled from a few parts, in units of the last place.
pub(crate) const ENTRY_ROUNDINGS: f64 = 4.0;

/// The absolute tolerance of a run that gives none, in parts of the distance that its motion goes.
pub(crate) const ABSOLUTE_PART: f64 = 1e-12;

/// A function given by the user is replaced by polynomials that differ from it by no more than this part of its largest value.
pub(crate) const FUNCTION_TOL: f64 = 1e-14;
/// Polynomials that replace a function, at the most; one that needs more is refused.
pub(crate) const MOST_FUNCTION_PIECES: usize = 1_000_000;
/// The motion of a stop may jump by this part of its largest value, and its slope by this part of the largest slope: that counts as
/// rounding of what was given.
pub(crate) const SMOOTH_MOTION: f64 = 1e-9;
/// A frequency is a whole multiple of another one where it differs from it by no more than this part.
pub(crate) const WHOLE_MULTIPLE: f64 = 1e-12;

// --- Dependence, rank and symmetry of matrices and directions.

/// Singular values of a matrix of directions, or of their products, below this part of its largest entry are zero: the directions are
/// linearly dependent.
pub(crate) const DEPENDENT: f64 = 1e-12;
/// Pivots of a scaled matrix up to this part of its largest entry are rounding: its columns are linearly dependent.
pub(crate) const DEPENDENT_ACTIVE: f64 = 1e-14;
/// Ratios of a pivoting method that differ by no more than this, absolutely and in parts of their size, are tied.
pub(crate) const TIE_TOL: f64 = 1e-12;
/// Asymmetry of an entry, in parts of the smaller of the largest entries of its row and its column, up to which a matrix counts as
/// symmetric. The matrix's largest entry is no measure: it may be a penalty elsewhere.
pub(crate) const SYMMETRY_TOL: f64 = 1e-12;
/// Where no pivot of a Delassus matrix is below this part of the largest, elimination is as accurate as the singular value decomposition,
/// and does not mix unknowns that are independent.
pub(crate) const SAFE_PIVOT: f64 = 1e-8;
/// A product of a reaction direction and a free direction below this part of their lengths is zero.
pub(crate) const ORTHOGONAL_TOL: f64 = 1e-12;
/// Entries of a recovery matrix whose stops have dependent normals may differ by this part of the largest from what each stop asks for:
/// then their restitutions agree.
pub(crate) const AGREEING_RESTITUTION: f64 = 1e-10;
/// Deviation of a given recovery matrix from a rule, relative to the sizes of its entries, that counts as rounding.
pub(crate) const AUDIT_TOL: f64 = 1e-9;

// --- Modes and flows.

/// Below this argument `sin(x)/x` is `1 - x^2/6` to the last digit.
pub(crate) const SINC_SERIES: f64 = 1e-4;
/// Squared frequencies of a real form that differ by no more than this part, or by their rounding, are those of a cluster, whose shapes
/// are chosen anew.
pub(crate) const EQUAL_FREQUENCIES: f64 = 1e-12;
/// Moduli of eigenvalues in the order of their modes are compared in this many parts of the largest.
pub(crate) const MODULUS_PARTS: f64 = 1e9;
/// The shift by which a matrix whose Schur form does not come is tried again, in parts of its largest entry.
pub(crate) const SCHUR_SHIFT: f64 = 1e-3;

/// An off-diagonal entry of the modal damping below this part of the larger diagonal entry of its two modes, or of the sizes of its own
/// terms, is rounding.
pub(crate) const PROPORTIONAL_TOL: f64 = 1e-12;
/// Ratio of the squared frequencies `K_ii/M_ii` of two coordinates, each on its own, beyond which errors in parts of the largest eigenvalue
/// would take four digits of the smallest; such a system is solved by a method that keeps them.
pub(crate) const GRADED: f64 = (1u64 << 13) as f64;
/// The same ratio beyond which no digits are left where the modes are complex: the errors of their vectors are its square root.
pub(crate) const TOO_GRADED: f64 = 1.0 / f64::EPSILON;
/// Imaginary parts of eigenvalues below this part of the largest eigenvalue are rounding.
pub(crate) const REAL_ROOT_TOL: f64 = 1e-12;
/// Condition number of an eigenvalue beyond which a matrix counts as defective: its modes would lose that factor of their digits, which the
/// matrix exponential does not.
pub(crate) const DEFECTIVE_CONDITION: f64 = 1e3;
/// Eigenvalues below this part of the largest are zero.
pub(crate) const ZERO_ROOT: f64 = 1e-12;
/// Eigenvalues between [`ZERO_ROOT`] and this part of the largest are a double one at zero, of a free body, that rounding has split: their
/// vectors are known to half the digits.
pub(crate) const SPLIT_ZERO_ROOT: f64 = 1e-7;
/// Real eigenvalues below this part of the largest are rounding of zero: what moves along their vectors stays where it is.
pub(crate) const STANDS_STILL: f64 = 1e-14;
/// A resonance is near where `|(i w - l_1)(i w - l_2)|` is below this times `w^2 + |l_1 l_2|`: the steady response and the
/// free motion would cancel in more than two digits.
pub(crate) const NEAR_RESONANCE: f64 = 1e-2;
/// Eigenvalues below this part of the fastest are those of a rigid body, which slow forcing moves whatever its motion is: its steady
/// response has no scale of its own.
pub(crate) const RIGID: f64 = 1e-9;
/// Distance in q, in units of the coordinates, within which an equilibrium counts as the one at q = 0.
pub(crate) const EQUILIBRIUM_TOL: f64 = 1e-12;
/// Part of its size by which an entry of a Jacobian given by the user may differ from a finite difference.
pub(crate) const WRONG_JACOBIAN: f64 = 1e-3;
/// Error of that finite difference, in parts of the largest entry of its column.
pub(crate) const ROUGH_JACOBIAN: f64 = 1e-6;

/// Rounding of an acceleration of which differences are taken, in parts of its largest entry.
pub(crate) const DIFFERENCED_ROUNDING: f64 = 16.0 * f64::EPSILON;
/// Part of their sizes by which the differences of an acceleration to both sides may differ before a shorter step is tried: their mean is
/// then off by the square of that.
pub(crate) const BENT_DIFFERENCE: f64 = 1e-4;
/// Part of their sizes up to which differences of two lengths agree: the square of [`BENT_DIFFERENCE`].
pub(crate) const SAME_DIFFERENCE: f64 = 1e-8;
/// Part of their sizes beyond which differences of no two lengths agree, so that the function counts as rough.
pub(crate) const DOUBTFUL: f64 = 1e-4;
/// Part of its size to which a deviation is known whose acceleration is a finite difference.
pub(crate) const DEVIATION_KNOWN: f64 = 1e-10;
/// The smallest size of deviations that are integrated beside a motion, in parts of the motion.
pub(crate) const SMALLEST_DEVIATION: f64 = 1e-6;
/// An acceleration is not smooth in one half of a step where this part of its change across the step lies there. Where it is smooth, only a
/// power of the time as high as the order of a method puts so much into one half, twice in a row.
pub(crate) const ONE_SIDED: f64 = 0.9;
/// Changes of an acceleration up to this part of its largest value are not jumps.
pub(crate) const ACCELERATION_JUMP: f64 = 1e-9;
/// Number of halvings in a row that must find most of the change in one half for an acceleration to jump.
pub(crate) const JUMP_HALVINGS: usize = 6;

// --- Contacts along a flight, and what happens at one instant.

/// Touches of one stop nearer to each other than this part of the step are one.
pub(crate) const SAME_TOUCH: f64 = 1e-6;
/// The quartic that interpolates a contact force along a step may be off by this part of the force.
pub(crate) const FORCE_TOL: f64 = 1e-4;
/// A contact force this small, in parts of its terms, is zero.
pub(crate) const FLAT_FORCE: f64 = 1e-12;
/// Impacts accumulate where the ratio of two successive impact speeds is the restitution e to within this.
pub(crate) const RATIO_TOL: f64 = 0.05;
/// What completing accumulating impacts at once neglects is up to this many times its estimate.
pub(crate) const CHATTER_SAFETY: f64 = 4.0;
/// A flight that rises by no more than this number of roundings of the gap has lost the digits of its impact speed.
pub(crate) const LOST_FLIGHT: f64 = 2.5;
/// A flight is low where the square of its impact speed is below this many times its acceleration times the depth that rounding left the
/// gap below zero.
pub(crate) const MOST_SUNK: f64 = 1e4;
/// Roundings that a gap may still be away from zero, at the most, where steps have reached its stop.
pub(crate) const MOST_LEFT: f64 = 100.0;
/// The estimate of the error of an interpolation may be too small by this factor.
pub(crate) const ERROR_FACTOR: f64 = 4.0;
/// An impact on one stop leaves the normal speed at another as it is where the product of its reaction direction and the other's normal is
/// below this part of their lengths.
pub(crate) const UNCOUPLED: f64 = 1e-12;
/// Part of their size by which two speeds that the impact law makes equal may differ.
pub(crate) const IMPACT_RATE_MATCH: f64 = 1e-9;
/// Two times that differ by no more than this part of them are one instant.
pub(crate) const INSTANT: f64 = 1e-12;
/// Acceleration of a gap, in parts of the largest terms of those in contact, that the rounding of a release time may leave where there is
/// none; of integrated motions the rounding of another stop's release too.
pub(crate) const RELEASED: f64 = 1e-9;
/// Third derivatives of gaps taken by finite differences are zero below this part of what the other stops add to them.
pub(crate) const STEADY_BY_STEPS: f64 = 1e-6;
/// Number of roundings of a gap up to which the stops that are held may keep it closed, where that is more than the absolute tolerance.
pub(crate) const FACING: f64 = 4.0;

// --- What motions settle on.

/// A motion this number of box widths away from its box has left it.
pub(crate) const LEFT_BOX: f64 = 1e3;
/// States nearer to each other than this part of the motion are one: it decides whether a motion repeats itself, whether two orbits are
/// one, and whether a search has advanced. The default tolerances of integration are far below it.
pub(crate) const SAME_STATE: f64 = 1e-6;
/// Rounding of positions in parts of the largest, below which states that repeat themselves do not tell whether they drift.
pub(crate) const RECURRENCE_ROUNDING: f64 = 1e2 * f64::EPSILON;
/// Two sets are one where at least this part of the [`NEAREST_NEIGHBOURS`] nearest neighbours of states of either belongs to the other; of
/// one set it is a half, but for chance and for motions that stay in a part of it for long.
pub(crate) const SHARED_MANY: f64 = 0.25;
/// Two sets are different where less than this part of those neighbours belongs to the other.
pub(crate) const SHARED_FEW: f64 = 0.01;
/// A state is on a set where its nearest neighbour in it is no farther than this many times the median distance of neighbours in the set.
pub(crate) const IN_SET: f64 = 4.0;

/// Numbers read from a file agree with their scene up to this part of the sizes of their terms: far more than the tolerances of any run
/// leave, far less than another scene differs by.
pub(crate) const KEPT_AGREES: f64 = 1e-2;

// --- Orbits.

/// What is left of the gap, in parts of the motion's size, below which an orbit takes the rest of accumulating impacts at once: less than
/// what an orbit closes to. In runs the tolerances decide.
pub(crate) const CHATTER_DEPTH: f64 = 2.5e-13;
/// Distance from the unit circle up to which a single root is on it: rounding alone.
pub(crate) const ON_UNIT_CIRCLE: f64 = 1e-12;
/// The same for a double root, where an orbit is at a fold: below the 1e-12 that must still be told apart.
pub(crate) const AT_FOLD: f64 = 8.0 * f64::EPSILON;
/// Phases [rad] nearer to each other than this are one that was found in the intervals on both sides of it.
pub(crate) const SAME_PHASE: f64 = 1e-11;
/// Smallest part of the solution that the direction along which the phase moves must have for the closed formula of one stop to be used.
pub(crate) const CLEAR_DIRECTION: f64 = 1e-6;
/// Smallest singular value of the two conditions of one stop, in units of order one, for which the closed formula is used; below it the
/// singular value decomposition decides. Far above the tolerance of the rank.
pub(crate) const CLEAR_RANK: f64 = 1e-4;
/// Residual of the periodic conditions, each in parts of its own terms, up to which they are solved.
pub(crate) const CONSISTENT: f64 = 1e-11;
/// Singular values of the periodic conditions below this part of the largest are zero (theory 5).
pub(crate) const CONDITIONS_RANK: f64 = 1e-10;
/// A mode is resonant, and keeps its two unknowns in the periodic conditions, where `det(I - e^{A T})` is below this part of its size.
pub(crate) const RETAIN_BELOW: f64 = 1e-4;
/// Mismatch of a root, in parts of the unknowns, up to which it is solved.
pub(crate) const CONVERGED: f64 = 1e-11;
/// Smallest singular value of the conditions of an orbit, in parts of the largest, above which Newton's method begins at the nearer of two
/// starts alone; below it, as at a symmetric orbit, both are tried.
pub(crate) const LEAVES_TWO_STARTS: f64 = 1e-4;
/// Distance from an undecided interval of flight times, in parts of the period T, within which its roots may lie.
pub(crate) const NEAR_FLIGHT_TIME: f64 = 1e-8;
/// Two roots whose flight times differ by no more than this part of T, and that have one phase, are one.
pub(crate) const SAME_FLIGHT_TIME: f64 = 1e-9;
/// Mismatch of further contacts, in parts of the unknowns, up to which stops are hit together.
pub(crate) const TOGETHER: f64 = 1e-9;
/// A flight time this near to a trivial one, in parts of T, is that one; the distance is far above rounding.
pub(crate) const TRIVIAL_FLIGHT: f64 = 1e-6;
/// Part of the range of flight times that may stay undecided before the outcome says so first.
pub(crate) const UNDECIDED_PART: f64 = 0.01;
/// Residual up to which the conditions for a motion to repeat itself have a solution.
pub(crate) const SOLVABLE: f64 = 1e-11;
/// A mode does not enter a row of conditions where its entries are below this part of the row's largest: rounding.
pub(crate) const UNCOUPLED_MODE: f64 = 1e-13;
/// Entries that vanish by symmetry are below this part of their terms.
pub(crate) const SPLIT_ROWS: f64 = 1e-13;
/// Largest mismatch, in scaled units, of an orbit that counts as closed.
pub(crate) const ORBIT_CLOSED: f64 = 1e-11;
/// The same for integrated flights: the errors of steps of 2e-13 add up to this over some thousand of them, where kinks and jumps of a
/// force make them differ from start to start.
pub(crate) const ORBIT_CLOSED_BY_STEPS: f64 = 5e-11;
/// Two rounds of a loop are one where it closes after the first to this part of its size.
pub(crate) const SAME_ROUND: f64 = 1e-8;
/// Mismatch, in scaled units, beyond which an orbit that is handed in is not one of the scene.
pub(crate) const ORBIT_OF_ANOTHER_SCENE: f64 = 1e-6;
/// Singular values below this part of the largest entry belong to directions in which an orbit may be changed freely.
pub(crate) const FREE_DIRECTION: f64 = 1e-12;
/// The same for integrated flights, whose errors depend on where they begin: along weaker directions a loop is corrected only where it
/// otherwise comes no nearer to closing.
pub(crate) const WEAK_DIRECTION: f64 = 1e-8;
/// What acts on a motion repeats itself where it makes accelerations a period later differ by no more than this part.
pub(crate) const REPEATS: f64 = 1e-9;
/// A return this near, in parts of the motion's size, counts as one; of a trajectory that has not settled so far the nearest return is
/// taken.
pub(crate) const RETURNED: f64 = 0.05;
/// A state this small, in parts of the motion, is one of rest: it is rounding.
pub(crate) const STATE_AT_REST: f64 = 1e-9;
/// Largest mismatch, in parts of the size of an orbit, by which the flights of an admissible orbit miss its beginning: 1e-9 in any norm.
pub(crate) const FLIGHTS_CLOSED: f64 = 3e-10;
/// The margin between touch and passage of a stop by an orbit, as [`TERM_ROUNDINGS`] is by a run: a gap this small counts as touching, in
/// parts of the motion's size along the normal. It is rounding of its position, with room to spare.
pub(crate) const ORBIT_MARGIN: f64 = 2e-13;
/// The same for integrated flights, in parts of the motion's size: what they are known to.
pub(crate) const INTEGRATED_MARGIN: f64 = 1e-10;
/// Margin of a contact force of an orbit, in parts of the sizes of its terms: at a release it is zero to what the orbit closes to.
pub(crate) const FORCE_MARGIN: f64 = 1e-10;
/// Number of margins within which a flight between two contacts is a low bounce, which a search that starts on the stop cannot tell from a
/// touch.
pub(crate) const LOW_BOUNCE: f64 = 100.0;
/// A largest multiplier whose modulus is this near to 1 decides nothing about stability.
pub(crate) const MARGINAL: f64 = 1e-9;
/// Two multipliers that meet are known to this, the square root of what a single one is known to.
pub(crate) const MEETING: f64 = 1e-6;
/// Rounding of the sum of the flight times of an orbit, in parts of the periods of the forcing that it is compared with.
pub(crate) const PERIOD_TOL: f64 = 1e-6;
/// Rounding of a time counted in periods, in parts of the largest time of a run.
pub(crate) const TIME_TOL: f64 = 1e-9;
/// Relative difference of two depths of violation beyond which a rough error does not change their order.
pub(crate) const DISTINCT: f64 = 1e-2;
/// Relative error of the depth of a violation that is small enough to tell two of them apart.
pub(crate) const ROUGH_MULTIPLIER: f64 = 1e-3;
/// Extremes of a motion that differ by no more than this part of its size are reached together.
pub(crate) const SAME_EXTREME: f64 = 1e-9;
/// A gap without an impact this small, in parts of the largest of its stop, or an approach speed this small, in parts of the motion's
/// largest, is a touch: numbers of the motion have a one-sided derivative there, and the steps of a difference lead across it.
pub(crate) const TOUCHED: f64 = 1e-9;

// --- Matrices, flights and contacts: linalg, modal, impact, flow, contact, hybrid.

/// Tolerances, in parts of the size of its terms, within which an entry of `M x + q` of a complementarity problem is zero; tried in turn:
/// rounding; rounding of an ill-conditioned M; columns of M that are nearly dependent, since a pivot is the square of the angle between
/// normals.
pub(crate) const COMPLEMENTARITY_ROUNDINGS: [f64; 3] = [1e-14, 1e-11, 1e-7];
/// Pivots of Lemke's method up to this are rounding, where the entries of the matrix are of order one; tried in turn: many dependent
/// columns need the larger ones, narrow angles between normals the smaller one.
pub(crate) const LEMKE_PIVOTS: [f64; 3] = [1e-11, 1e-13, 1e-9];
/// A quadratic form whose terms are together no more than this times its value is summed in doubles: three of their sixteen digits may
/// cancel. Beyond, it is summed in twice the precision.
pub(crate) const COMPENSATED_LOSS: f64 = 1e3;
/// A column of a matrix counts with no less than this part of the longest one's length in the product that a determinant is measured by:
/// half the digits of a double. A shorter column makes the ratio small instead of leaving it undefined.
pub(crate) const LEAST_COLUMN: f64 = 1e-8;
/// Ratio of the largest entries of a row and of the column of the same number beyond which a matrix is balanced, by powers of two, before
/// its eigenvalues are taken. Chosen, not derived.
pub(crate) const UNBALANCED_RATIO: f64 = 1e4;
/// Eigenvalues nearer to each other than this part of the larger do not mix in the refinement of eigenvectors: the correction, the residual
/// over their distance, would be rounding by 1e6.
pub(crate) const CLOSE_ROOTS: f64 = 1e-6;
/// Largest Newton correction of an eigenvalue, in parts of the largest eigenvalue, that counts as one of rounding; a larger one says that
/// the eigenvectors are nearly dependent, and nothing is refined.
pub(crate) const ROOT_REFINEMENT: f64 = 1e-6;
/// Largest Newton correction of a unit eigenvector, in parts of the other eigenvectors, that counts as small: what a step leaves is its
/// square, 1e-6.
pub(crate) const VECTOR_REFINEMENT: f64 = 1e-3;
/// A matrix with an entry of this size has no exponential in doubles: it would have no correct digit, and the squarings of its powers
/// overflow.
pub(crate) const HOPELESS_EXPONENT: f64 = 1e20;
/// Two columns are orthogonal where their product is no more than this many roundings for each of its terms. With fewer, chance would turn
/// some matrices for ever.
pub(crate) const ORTHOGONAL_COLUMNS: f64 = 2.0;
/// Angle [rad] that a block of a complex pair must have turned by for its response across the two unknowns to be taken as a difference of
/// two exponentials: at a smaller one that cancels by more than two bits, and a divided difference is taken.
pub(crate) const SPIRAL_TURN: f64 = 0.25;
/// Distance of an exponential from 1 from which on the difference is taken as it is: it keeps all digits but one or two bits. Nearer, a
/// form without cancellation is taken.
pub(crate) const FAR_FROM_ONE: f64 = 0.5;
/// Rounds of impacts at one instant after which the stops count as closing one another for ever; a last round without restitution ends it
/// (`ResolvedImpacts::is_inelastic`). Chosen, not derived; the documentation of `resolve_impacts` promises it.
pub(crate) const MOST_IMPACT_ROUNDS: usize = 100;
/// Number of slacks of the opening speeds to which the impact law is solved: two for the factor 1 + e on each speed, two more so that a
/// feasible problem stays feasible.
pub(crate) const IMPACT_LAW_SLACKS: f64 = 4.0;
/// Number of slacks within which an opening speed is zero after speeds have been thrown to and fro between facing stops: rounding of
/// several rounds adds up. Chosen, not derived.
pub(crate) const THROWN_SLACKS: f64 = 10.0;
/// Rounds of impacts at one instant beyond which facing stops have thrown speeds back to where they came from.
pub(crate) const THROWN_ROUNDS: usize = 2;
/// Ratio of the lengths of two finite differences that are compared: the error of a central one, which goes as the square of its length,
/// differs by 256 between them.
pub(crate) const DIFFERENCE_RATIO: f64 = 16.0;
/// Number of times that the step of a finite difference is shortened by that ratio, at the most: the shortest is 4e-13 of the state's size,
/// where rounding takes over.
pub(crate) const DIFFERENCE_LEVELS: i32 = 6;
/// Level of the step with which a difference is tried at the next place beside a kink or a jump: 1.5e-9 of the state's size, which leads
/// across it only from near by.
pub(crate) const KINK_LEVEL: i32 = 3;
/// Places farther apart than this number of longest difference steps are not beside one and the same kink or jump: where no two lengths
/// agree over such a distance, the function is rough. Chosen, not derived.
pub(crate) const KINK_DISTANCE: f64 = 64.0;
/// Last step of Newton's method for the root of a falling cubic, in parts of the span: its error is the square of that, 1e-10, less than
/// what the cubic leaves of the gap.
pub(crate) const FALLING_ROOT_STEP: f64 = 1e-5;
/// Rates of a linear motion slower than this part of the fastest change nothing in doubles while anything else moves, and do not set the
/// longest step: a hundredth of a rounding.
pub(crate) const SLOWEST_RATE: f64 = 1e-18;
/// Relative tolerance from which on the explicit method that is chosen is that of few stages, of order 5; below it that of order 8, whose
/// longer steps then need fewer evaluations. Chosen, not derived.
pub(crate) const LOOSE_RELATIVE_TOLERANCE: f64 = 1e-7;
/// The next step of an integrator aims at this part of the length at which its error would be the tolerance (Hairer, Norsett and Wanner I,
/// section II.4).
pub(crate) const STEP_SAFETY: f64 = 0.9;
/// Error of a step, in units of the tolerance, below which the controller no longer heeds it when it sets the next step: the value of the
/// codes of Hairer, Norsett and Wanner I, section IV.2.
pub(crate) const LEAST_STEP_ERROR: f64 = 1e-4;
/// Errors of a step below this part of what is allowed make the next one no longer than this does.
pub(crate) const LEAST_SCALED_ERROR: f64 = 1e-10;
/// A state or its rate below this, in units of the tolerance, says nothing of the length of a first step, which is then
/// [`SMALL_FIRST_STEP`].
pub(crate) const SMALL_STATE: f64 = 1e-5;
/// The first step that is tried where the state says nothing of its length [s].
pub(crate) const SMALL_FIRST_STEP: f64 = 1e-6;
/// The part of a first step by which an Euler step may move the state, or the error of the method may be of the tolerance.
pub(crate) const EULER_STEP_PART: f64 = 0.01;
/// Rates below this, in units of the tolerance, are none: the first step is [`FIRST_STEP_OF_REST`] of the one that was tried.
pub(crate) const NO_RATE: f64 = 1e-15;
/// The first step of a motion at rest, in parts of the one that was tried.
pub(crate) const FIRST_STEP_OF_REST: f64 = 1e-3;
/// Number of steps limited by stability after which a motion is called stiff, unless [`SOUND_STEPS`] in a row between them are not: the
/// values of the codes of Hairer and Wanner II, section IV.2.
pub(crate) const STIFF_STEPS: u32 = 15;
/// Number of steps in a row not limited by stability after which those that were are forgotten.
pub(crate) const SOUND_STEPS: u32 = 6;
/// Factor from one increment of the simplified Newton iteration of an implicit step to the next from which on it does not converge (Hairer
/// and Wanner II, section IV.8).
pub(crate) const NEWTON_DIVERGENCE: f64 = 0.99;
/// Part of the first increment of an implicit step that counts as left after it, at the least, however fast the iterations before
/// converged: the equations may have changed, as where a spring is met. Chosen, not derived.
pub(crate) const FIRST_INCREMENT_LEFT: f64 = 1e-2;
/// A piece of a step that is proved to hold no contact leads nowhere where it is shorter than this part of what is left of the step: the
/// search ends without a certificate. Chosen, not derived.
pub(crate) const SHORTEST_PIECE: f64 = 1e-12;
/// A minimum of a gap between two evaluations is located where one of them is no more than this number of tolerances above zero: from
/// higher up no piece leads across a minimum.
pub(crate) const NEAR_MINIMUM_TOLERANCES: f64 = 10.0;
/// Part of the tolerance below zero at which a gap that began on its stop, and has not opened, has passed it: half, as the pieces of the
/// search may end anywhere down to all of it.
pub(crate) const PASSED_TOLERANCE_PART: f64 = 0.5;
/// The tolerance of a gap along a step is no less than this number of roundings of its terms.
pub(crate) const GAP_KNOWN_ROUNDINGS: f64 = 4.0;
/// A correction of an impact time this small, in units of one over the fastest rate, moves the state by its Taylor series of third order:
/// what that leaves out, a part x^4/24 = 7e-17, is below rounding.
pub(crate) const TAYLOR_TIME: f64 = 2e-4;
/// Last step of Newton's method for the root of a cubic, in parts of the root: its error is the square of that, a rounding.
pub(crate) const CUBIC_ROOT_STEP: f64 = 1e-8;
/// A step of Newton's method for a contact is taken as it is up to this part of the time since the flight began on the same stop; a longer
/// one is taken on the gap over a power of the time, which does not fall back to the root at the start. Chosen, not derived.
pub(crate) const NEWTON_NEAR_ZERO: f64 = 0.25;
/// A motion is taken to be off the quintic through both ends of its step by less than this part of what the Bernstein coefficients of the
/// quintic spread over, where only its clearance from a stop is asked. Chosen, not derived.
pub(crate) const QUINTIC_ERROR_PART: f64 = 0.1;
/// A gap without a known curvature may differ from its quintic by this part of what it changes by along the step. Chosen, not derived.
pub(crate) const UNLIKE_QUINTIC: f64 = 1e-3;
/// A difference of a gap from its quintic counts where the gap comes as near to zero as this many times the difference. Chosen, not
/// derived.
pub(crate) const NEAR_MISS_FACTOR: f64 = 10.0;
/// Part of a step below which a gap given by a Taylor series is not divided any further: the contact stays undecided. The precision of a
/// double.
pub(crate) const SHORTEST_SERIES_PART: f64 = f64::EPSILON;
/// Number of [`CHATTER_DEPTH`]s within which what is left of accumulating impacts may already be too low for a next contact to be found:
/// then the rest begins one impact earlier.
pub(crate) const NEAR_CHATTER_DEPTH: f64 = 10.0;
/// Number of times as many evaluations as a gap bends for from which on the bound on its curvature is called loose, in remarks and where a
/// search is given up.
pub(crate) const LOOSE_CURVATURE: f64 = 32.0;
/// Evaluations of one gap in a run beyond which a loose bound on its curvature is remarked on.
pub(crate) const NOTICED_SEARCH_POINTS: usize = 1 << 12;
/// Angle [rad] that the links before a wall may turn by in a step for the quintic through its ends to be taken for the gap: it is off by
/// 2e-5 of the length of a link that turns evenly.
pub(crate) const QUINTIC_TURN: f64 = 1.0;
/// The same for methods whose quintic only has to show that the gap is far from zero.
pub(crate) const FAR_QUINTIC_TURN: f64 = 3.0;
/// Step of the difference of a gap's accelerations that its third derivative is, in parts of the time in which the motion changes little;
/// lengthened up to 1e4 times where the difference is rounding.
pub(crate) const JERK_STEP: f64 = 1e-4;
/// The steps that are tried in turn, in units of the shortest.
pub(crate) const JERK_STEPS: [f64; 5] = [1.0, 10.0, 1e2, 1e3, 1e4];
/// A correction of a step's length to a contact below this part of the step, times the root of the relative tolerance, moves the state by
/// its Taylor series of second order: the velocity is then wrong by 5e-5 of the tolerance.
pub(crate) const TAYLOR_STEP_PART: f64 = 1e-2;
/// Part of a step by which the minimum of a gap may be away from where the interpolation has it; farther on it is another one. Chosen, not
/// derived.
pub(crate) const LOWEST_NEAR_GUESS: f64 = 0.25;
/// Angle [rad] that a link may turn by in a step along its Taylor series before it is checked whether the sine in a gap is known to the
/// tolerance as its angle is; in usual steps it is.
pub(crate) const SINE_TURN: f64 = 2.0;
/// Times in a row that a step is shortened where it cannot tell a contact from none, by halves to 2e-4 of its length. After that a minimum
/// that cannot be told from zero counts as no contact: it is no deeper than the interpolation is off by on so short a step.
pub(crate) const MOST_STEP_HALVINGS: usize = 12;

// --- Scenes, runs and their records: model, path, recurrence, simulate, section.

/// The time, in parts of a step, over which the speed of a nonlinear gap is differenced along the motion for the second derivative of the
/// gap: `s = 1e-5 step`. That derivative enters the gap over a step with the weight `step^2/60`: rounding of the gradient then amounts to
/// `1e5/60` units in the last place of the gap's change over the step, the truncation `s^2/6` to 1e-12 of the step's fourth order, both
/// below any tolerance. A gap of second degree has no truncation.
pub(crate) const GAP_DIFFERENCE_STEP: f64 = 1e-5;
/// Part of the terms of a gap's speed up to which the speed may change over that difference. Beyond it a shorter difference has to agree,
/// whatever the step: links turn many times in the steps of a free flight. The truncation of a central difference is of the order of the
/// square of this.
pub(crate) const LARGE_SPEED_CHANGE: f64 = 1e-3;
/// The factor by which that difference is then made shorter, [-]: the truncation falls by its square, 256, so that two differences that
/// agree to [`SAME_GAP_CURVATURE`] have converged.
pub(crate) const SHORTENING_FACTOR: f64 = 16.0;
/// Part of its value to which the second derivative of a gap by two differences agrees where it is taken: about the square root of the
/// rounding unit.
pub(crate) const SAME_GAP_CURVATURE: f64 = 1e-8;
/// Part of its value below which the change from one difference to the next belongs to a sequence that converges: once such changes grow
/// again, they are rounding, and the best so far is taken.
pub(crate) const GAP_CURVATURE_CONVERGING: f64 = 1e-3;
/// Rounding of a gap's speed, in parts of its terms, below which two differences of it agree whatever they give: a gradient is known to
/// some units in the last place. Checked on the end of a rod over steps in which it turns by 0.1 to 1e7 radians.
pub(crate) const GAP_SPEED_ROUNDINGS: f64 = 64.0 * f64::EPSILON;
/// The longest time that counts as one over which a motion changes little, in parts of the time that it takes to go as far as its position
/// is large: where the acceleration is smaller still, it says nothing of that time. No reason for the size is recorded; second derivatives
/// of gaps over such times were checked on the end of a rod.
pub(crate) const SLOWEST_SPEED_CHANGE: f64 = 1e3;
/// The longest step of Ridders' differences of a given function, in units of its argument. The steps go down from it to 2e-12, so that some
/// fit a function of any scale from 1e-6 to 1e3, for which it was checked.
pub(crate) const RIDDERS_FIRST_STEP: f64 = 0.5;
/// The ratio of each of those steps to the one before: extrapolation gains a factor of its square, 16, in each order.
pub(crate) const RIDDERS_SHRINK: f64 = 0.25;
/// Error of such a derivative, in parts of its value, above which it does not exist: the function jumps there. A smooth one is known to
/// 1e-9 and better.
pub(crate) const UNSETTLED_DERIVATIVE: f64 = 1e-4;
/// An error of such a derivative this small, in parts of the usual size of a difference quotient or of the function, is that of a
/// derivative of zero.
pub(crate) const ZERO_DERIVATIVE: f64 = 1e-9;
/// The step of a central difference of accelerations and of maps, in parts of the size of the state: the cube root of the rounding unit, at
/// which truncation and rounding are alike.
pub(crate) const CENTRAL_DIFFERENCE_STEP: f64 = 6e-6;
/// The step of the fourth-order differences of an energy along a motion, in parts of a time over which the motion changes little. The
/// truncation is of the order of `(1/16)^4/30` of the step's fifth power, below any error of a step; rounding amounts to 16 units in the
/// last place of the energy for each step.
pub(crate) const ENERGY_DIFFERENCE_STEP: f64 = 1.0 / 16.0;
/// The highest whole multiple of the lowest frequency [-] that counts as a harmonic of it; scenes with higher ones have no period, as
/// `Forcing` documents. No reason for the size is recorded.
pub(crate) const HIGHEST_MULTIPLE: f64 = 4096.0;
/// Length of a piece of a function, in parts of the interval between two breaks (2^-26), up to which it may be a straight line: halving has
/// led to a corner there, and high powers would have no digits.
pub(crate) const CORNER_PIECE_LENGTH: f64 = 1.0 / 67_108_864.0;
/// The ratio of the error of a line at a corner to that at the sampled points [-]: the corner may lie between an end and the next point.
pub(crate) const CORNER_ERROR_FACTOR: f64 = 2.0;
/// Part of its largest value by which a function may change over the last places of the time and still count as continuous: more is a jump.
pub(crate) const FUNCTION_JUMP: f64 = 1e-6;
/// Distance from a break at which a function is evaluated on either side of it, in last places of the time: so far that rounding does not
/// put the point onto the break or across it.
pub(crate) const BREAK_SIDE_ROUNDINGS: f64 = 2.0;
/// Last places of the time by which the time of a value of a function is unknown. Where the function is smooth, a time is off by half of
/// one, being a sum that is rounded, and the function takes another half or so where it first multiplies the time; a polynomial through
/// nine such values is off by 2.3 times that between them, and the value that it is compared with by once: 3.3. At a corner halving ends at
/// a piece with one or two times inside, two or three last places long: all its times are sampled, and its values are not farther apart
/// than the steepest slope makes of its length, 3. So what is steep and continuous is followed, whatever the function rounds; a jump is
/// more than [`FUNCTION_JUMP`]. The error is that at the sampled points: at a corner between them a polynomial of degree 8 is off by up to
/// 6.8 times as much.
pub(crate) const SAMPLE_TIME_ROUNDINGS: f64 = 4.0;
/// A function is rough where the error on half a piece is more than this part of the error on the whole piece: halving takes a smooth one
/// to 1/512, and one with a corner to a half. What is left is then rounding of the function, if it is no more than the last places of the
/// span's times make of its slope, there or where it is steepest (where slopes of terms cancel, their roundings do not).
pub(crate) const ROUGH_HALVING: f64 = 0.7;
/// The largest error of a rough function, in parts of its largest value, that counts as its rounding where the function itself is known to
/// no more than a given accuracy.
pub(crate) const ROUGH_FUNCTION: f64 = 1e-9;
/// Samples over the whole span of a function, two neighbours no farther apart than twice the mean distance: two or more lie in a feature
/// that lasts a thousandth of the span, as `Signal::from_function` promises.
pub(crate) const FUNCTION_SAMPLES: usize = 4096;
/// The longer step of one-sided differences by which a given derivative is checked at a kink, in units of the coordinates: its rounding is
/// 2e-10 of the acceleration, far below [`WRONG_JACOBIAN`].
pub(crate) const ONE_SIDED_STEP: f64 = 1e-6;
/// The shorter step of those differences, in units of the coordinates, which a second kink beside the first does not reach; its rounding is
/// 2e-7 of the acceleration.
pub(crate) const SHORT_ONE_SIDED_STEP: f64 = 1e-9;
/// Times [s] at which q = 0 must be at rest for a nonlinear system to be linearised about it: three without a common measure, so that no
/// harmonic force is zero at all of them.
pub(crate) const EQUILIBRIUM_TIMES: [f64; 3] = [0.0, 1.0, std::f64::consts::SQRT_2];
/// How far the signals of a drifting scene go on beyond the end of their span, in parts of it or of the shortest period over 2 pi,
/// whichever is less: they hold at its end, too. Long against the rounding of a time and short against any motion; nothing else is recorded
/// of its size.
pub(crate) const DRIFT_OVERHANG: f64 = 1.0 / 64.0;
/// The least of that, in last places of the time: the signals then hold at the end of the span whatever rounding makes of it.
pub(crate) const DRIFT_OVERHANG_ROUNDINGS: f64 = 16.0;
/// Where arcs of a saved motion are sampled for its largest positions and velocities, in parts of the arc: a symmetric motion is not zero
/// at all of them.
pub(crate) const ARC_SIZE_SAMPLES: [f64; 3] = [0.2, 0.45, 0.7];
/// A gap of no more than this part of its terms is closed at an impact of a kept motion: above what the default tolerance of a run, 1e-9,
/// leaves of a gap.
pub(crate) const CLOSED_AT_IMPACT: f64 = 1e-6;
/// Exponent of a decay [-] after which a part of a motion has died out beside its own first size: `e^-45 < 3e-20`, below rounding.
pub(crate) const DIED_OUT_EXPONENT: f64 = 45.0;
/// Angle [rad] by which a block turns, or exponent by which it decays, along an arc where its part of a contact force is integrated in
/// closed form. Below it quadrature takes no more than forty stretches of [`QUADRATURE_STRETCH`].
pub(crate) const FAST_TURN: f64 = 20.0;
/// Longest stretch of an exact flight to which Gauss's rule of six points is applied at once, in radians of the fastest motion there: its
/// error, of twelfth order, is then below rounding.
pub(crate) const QUADRATURE_STRETCH: f64 = 0.5;
/// The most states of a motion whose nearest neighbours are counted to tell whether two sets are one. With [`NEAREST_NEIGHBOURS`] of each
/// there are some thousand counts, and the shares of which [`SHARED_MANY`] and [`SHARED_FEW`] speak are known to some hundredths.
pub(crate) const QUERIED_STATES: usize = 500;
/// Nearest neighbours that are counted of each of those states. Checked on circles and on the map of Henon.
pub(crate) const NEAREST_NEIGHBOURS: usize = 8;
/// Times that a stop is released at one instant before the law of the contact forces decides instead of the order of their roots, or that
/// it opens late and is back at once before it is held: the first release at an instant may be due to another stop that leaves, the second
/// is its own.
pub(crate) const RELEASES_AT_ONCE: usize = 2;
/// What is left of the dwell of a ramp's level, in parts of the dwell, at which it has ended: rounding of turns that are counted up from
/// change to change.
pub(crate) const DWELL_ROUNDING: f64 = 1e-9;

// --- Periodic motions: orbit.

/// Impulses of two instants half a period apart that differ by no more than this part of the largest are those of an orbit of half the
/// period, gone through twice: some ten times `TRIVIAL_FLIGHT`, to which the instants are known to be that far apart.
pub(crate) const REPEATED_IMPULSE: f64 = 1e-5;
/// Two roots at one flight time (`SAME_FLIGHT_TIME`) are one where their scaled unknowns differ by no more than this part of the largest. No
/// finer reason is known.
pub(crate) const SAME_ROOT_UNKNOWNS: f64 = 1e-6;
/// Singular values below this part of the largest entry of the two-instant conditions are zero while Newton's method is given its first
/// unknowns by least squares: half the digits, as the flight time is only guessed.
pub(crate) const LEAST_SQUARES_RANK: f64 = 1e-8;
/// The same of the bordered system of a Newton step that has no solution otherwise: rounding alone.
pub(crate) const SINGULAR_STEP_RANK: f64 = 1e-13;
/// The part of the span of a flight from which on the bracket of a turn next to a place is doubled: above the rounding of times along the
/// flight, and far below the distance of two turns.
pub(crate) const FIRST_BRACKET_PART: f64 = 1e-9;
/// Degrees of freedom above which orbits are listed by admissibility alone: their multipliers cost O(n^3) and are computed only when asked
/// for. The documentation of `Orbits` says it.
pub(crate) const MOST_DOF_SORTED_BY_STABILITY: usize = 60;
/// Turns of the fastest mode, or of the forcing, in a period beyond which its phase is lost: a phase of so many turns is known to three
/// digits of a radian, and a flight that long is not searched in a day.
pub(crate) const MOST_TURNS_IN_PERIOD: f64 = 1e12;
/// The angle [rad] by which the determinant may turn from one point of the unit circle to the next while multipliers outside are counted: a
/// third of the half turn beyond which the direction is not known.
pub(crate) const WINDING_TURN: f64 = 1.0;
/// The part of the distance to the nearest multiplier of a mode, a pole of the determinant, that a step along the circle may be: a pole then
/// turns it by less than 1 rad.
pub(crate) const WINDING_STEP_PART: f64 = 0.5;
/// The longest angle [rad] between points of the circle: some ten to the half circle.
pub(crate) const LONGEST_WINDING_STEP: f64 = 0.3;
/// The shortest angle [rad] between points: a multiplier nearer to the circle leaves the count undecided. Below `MARGINAL`, within which a
/// multiplier decides nothing anyhow.
pub(crate) const SHORTEST_WINDING_STEP: f64 = 1e-10;
/// Modes of which no more than this part is left after a period are summed up as powers of it: `QUIET_POWERS` of them leave 3e-14.
pub(crate) const QUIET_MODE: f64 = 0.02;
/// Powers of what a period leaves of a quiet mode (`QUIET_MODE`) that are summed: the rest is below 1e-13.
pub(crate) const QUIET_POWERS: usize = 8;
/// A mode of which this part or more is left after a period does not decay: its response to an impulse that is repeated, a sum over all
/// periods before, is a million times the impulse there, and loses as many digits.
pub(crate) const DECAYING_MODE: f64 = 1.0 - 1e-6;
/// Periods for which the motion from a state is simulated to read a guess off it: until its first instant at the latest
/// (`GUESS_WAIT_PERIODS`), and from there until that has returned, a period later with a quarter to spare.
pub(crate) const GUESS_RUN_PERIODS: f64 = 2.5;
/// Periods in which the first instant of that motion must come, or it is taken for one without instants: one, with a quarter to spare.
pub(crate) const GUESS_WAIT_PERIODS: f64 = 1.25;
/// What opposite sides of an odd scene may differ by, relative to their size: above the rounding of accelerations and of the functions that
/// make them. No finer reason is known.
pub(crate) const OPPOSITE_SIDES: f64 = 1e-10;
/// A scaled mismatch of a loop at or below which no further step is taken: that of a motion that stands still could be made smaller without
/// end. Far below the rounding of any other.
pub(crate) const ZERO_MISMATCH: f64 = 1e-18;
/// Without forcing a motion of which no more than this part of the speed of the guess is left is none: Newton's method has shrunk it to a
/// state of rest, which closes at any period.
pub(crate) const SHRUNK_MOTION: f64 = 1e-8;
/// A loop that does not close is near a fold where the smallest singular value of its equations is this part of the largest, or less; it
/// decides what the failure says. No finer reason for its size is known.
pub(crate) const NEAR_FOLD: f64 = 3e-3;
/// The factor on second differences of a function known by values, for what they may be between the places at which they are known, before
/// they exclude a root [-].
pub(crate) const SECOND_DIFFERENCE_SAFETY: f64 = 2.0;
/// The part of the elastic speed, that of the same strain in free vibration, down to which a velocity is known where it is asked whether an
/// orbit closes: of a motion near rest nothing is left but the rounding of its strain. No finer reason is known.
pub(crate) const ELASTIC_SPEED_PART: f64 = 1e-4;
/// The part of the shortest step of a flight down to which a step is halved while the values of a nonlinear gap do not agree with its
/// quintic; below that the lowest of the values themselves is taken. The quintic is of sixth order: halved ten times, it is off by 1e-18 of
/// what it was.
pub(crate) const SHORTEST_JUDGED_STEP: f64 = 1e-3;

// --- Deviations: derivative, exponents.

/// An impact slower than this part of the largest speed of its run is a touch that the rounding of the gap has made one: the root of what
/// gaps are known to, 1e-14 of the motion, as a gap has the square of the speed at a touch. Such a run has no derivatives beyond it.
pub(crate) const TOUCHING_IMPACT_SPEED: f64 = 1e-7;
/// A stop whose gap is no larger than this part of the motion at an impact on another is hit together with it: ten times what gaps along
/// flights of steps are known to.
pub(crate) const HIT_TOGETHER_GAP: f64 = 1e-9;
/// Growth of scaled deviations along a flight of a nonlinear system beyond which the flight is cut in two [-]: a step of a difference, 1e-3
/// of the motion at most, then stays a hundredth of it.
pub(crate) const FLIGHT_CUT_GROWTH: f64 = 10.0;
/// Halvings of the line between two sets of numbers along which an orbit is followed by Newton's method. Where it is still far from the orbit
/// that is found on the shortest part, continuation decides, which is slower.
pub(crate) const FOLLOWING_HALVINGS: usize = 6;
/// The phase [rad] by which an impact of an orbit that is followed may move over one part of the line between two sets of numbers: less than
/// a twelfth of a turn, so that impacts of one stop are not taken for each other. No finer reason is known.
pub(crate) const TRACKED_PHASE_SHIFT: f64 = 0.5;
/// The same of its approach speed, in parts of the largest of the orbit: half of it. No finer reason is known.
pub(crate) const TRACKED_SPEED_CHANGE: f64 = 0.5;
/// The step of a central difference of second order by a number of a scene, in parts of the scale of the number, where flights are in closed
/// form: the cube root of the rounding of doubles, which such flights are known to.
pub(crate) const DERIVATIVE_STEP_EXACT: f64 = 6e-6;
/// The same where flights are integrated: the cube root of 2e-13, the tolerance of their steps.
pub(crate) const DERIVATIVE_STEP_INTEGRATED: f64 = 6e-5;
/// The same where impacts accumulate, by differences of fourth order, of values that are known to `LOOP_VALUE_NOISE` alone: the second of the
/// steps that are tried (`FIRST_CHATTER_STEP`).
pub(crate) const DERIVATIVE_STEP_CHATTER: f64 = 1e-3;
/// The scale of a number is too small where a change of it by that scale changes the residuals of a loop by less than this, in units of the
/// motion: a step, a small part of the scale, would be lost in rounding.
pub(crate) const LEAST_STEP_EFFECT: f64 = 0.05;
/// The factor within which two scales of a number are as good as each other for a step [-]: the error of a difference of second order then
/// grows by no more than the square of it.
pub(crate) const SAME_STEP_SCALE: f64 = 4.0;
/// A multiplier is one of several, and has no derivative, where another is this near to it, in parts of the largest, or where `w (J_1 - J_0)
/// v` is this part of its factors: half the digits of an orbit that is known to 1e-11 are left.
pub(crate) const DEFECTIVE_MULTIPLIER: f64 = 1e-5;
/// Where no other multiplier is nearer than this part of its own modulus it is simple, however sensitive. Far above the distance at which
/// multipliers meet (`DEFECTIVE_MULTIPLIER`); no finer reason is known.
pub(crate) const ISOLATED_MULTIPLIER: f64 = 0.1;
/// The scale of a restitution coefficient e of accumulating impacts, which go on for as long as `1/(1 - e)`, is `1 - e`, but no less than
/// this [-]. No finer reason is known.
pub(crate) const LEAST_RESTITUTION_LOSS: f64 = 1e-3;
/// Derivatives of one extreme at the several times at which it is reached agree, and the extreme has a derivative, where they differ by no
/// more than this part of the largest derivative of a position or an extreme. No finer reason is known.
pub(crate) const SAME_EXTREME_RATE: f64 = 1e-6;
/// What is not known of the numbers measured of a loop, in parts of their units: that of the times of accumulating impacts, rounding over the
/// speed of the last (of a gap of `CHATTER_DEPTH`, some 5e-7 of the motion).
pub(crate) const LOOP_VALUE_NOISE: f64 = 1e-9;
/// The unit of the equations of deviations beyond accumulating impacts, in which they are known to `LOOP_VALUE_NOISE`: their rounding is
/// about this much larger [-].
pub(crate) const DEVIATION_NOISE_UNIT: f64 = 10.0;
/// The factor from one step to the next where the loops beside an orbit have other accumulating impacts, or differences of two orders do not
/// agree [-]: the error of fourth order falls by 4e-4.
pub(crate) const STEP_REFINEMENT: f64 = 0.125;
/// The factor on `DERIVATIVE_STEP_CHATTER` with which the steps begin [-]: the longer a step, the less is felt of what is not known of such
/// loops; one refinement leads to the usual step.
pub(crate) const FIRST_CHATTER_STEP: f64 = 8.0;
/// The steps that are tried for a difference of fourth order of a run, in parts of the scale of a number, longest first: the first is the
/// fifth root of what is known of its values, 1e-13 and better, but for a factor of three; shorter ones are for motions that bend more.
pub(crate) const RUN_DERIVATIVE_STEPS: [f64; 4] = [1e-3, 1e-4, 1e-5, 1e-6];
/// What rounding and the errors of flights leave unknown of the states of a run, in parts of the motion: some fifty times the tolerance of
/// integrated steps.
pub(crate) const RUN_VALUE_NOISE: f64 = 1e-11;
/// Two instants of an orbit that are this near to each other, in parts of the period, are one, and the orbit has no derivatives: a hundred
/// times what loops close to.
pub(crate) const COINCIDENT_INSTANTS: f64 = 1e-9;
/// A lasting contact no longer than this part of the period has no derivatives: where there is none its duration has none, and near that no
/// digits of it would be left.
pub(crate) const SHORT_CONTACT: f64 = 1e-6;
/// The smallest singular value of the equations of a loop, in parts of the largest, at or below which an orbit is at a fold or in a family:
/// what orbits are known to, 1e-11, over its square is what is known of a derivative.
pub(crate) const SINGULAR_LOOP: f64 = 1e-5;
/// The part of the rates of the equations of a loop along the left vector of that singular value up to which a number does not push an orbit
/// along its family; with a larger one the orbit is at a fold.
pub(crate) const FAMILY_PART: f64 = 1e-6;
/// Differences of second and of fourth order over one step agree, and no shorter step is tried, where they differ by no more than this part
/// of the derivative: that of fourth order is off by the square of it, 1e-8, or less.
pub(crate) const DIFFERENCES_AGREE: f64 = 1e-4;
/// Beyond this part of the derivative they say nothing, and there is no derivative: the square of it is 1e-3.
pub(crate) const DIFFERENCES_DISAGREE: f64 = 3e-2;
/// Batches that the time that counts is divided into for the errors of Lyapunov exponents; the largest number of rows in their history. Of
/// twenty means the standard error is itself known to a sixth.
pub(crate) const FINEST_BATCHES: usize = 20;
/// Returns (periods of the forcing, or impacts) that each batch must have, so that its mean is one of many that do not depend on each other,
/// as the error of the mean of batches supposes. The documentation of `lyapunov_exponents` promises it.
pub(crate) const RETURNS_PER_BATCH: usize = 50;
/// Ratio of the largest growth of deviations to the smallest over a piece of a flight above which the flight is cut [-]: the slowest
/// direction would lose half of its digits to the fastest one.
pub(crate) const MOST_TANGENT_SPREAD: f64 = 1e8;
/// A direction of deviations of which contact leaves no more than this part of the largest is taken away: what is left is rounding, and its
/// exponent is minus infinity.
pub(crate) const COLLAPSED_DIRECTION: f64 = 1e-12;
/// A direction of which an impact leaves less than this part of the largest entry has lost a third of its digits: what it has grown by is
/// taken from the determinant instead.
pub(crate) const TANGENT_DIGITS_LOST: f64 = 1e-5;

// --- Branches.

// Lengths are arclengths in the scaled unknowns of a branch (theory 19): positions and velocities in units of the motion's own size,
// phases of the forcing in radians, the parameter in parts of its range. "Range" is the width of the range of the parameter, [unit of the
// parameter]; the period is that of the motion, [s].

/// A step is refused if the second correction of Newton's method is longer than this part of the first \[-\]: the predictor then lies at
/// the edge of where the method converges (theory 19).
pub(crate) const STEP_CONTRACTION_LIMIT: f64 = 0.5;
/// A step is refused if the tangent turns by more than this angle \[rad\]: more than twice [`USUAL_STEP_ANGLE`], so that step control
/// seldom meets it (theory 19).
pub(crate) const STEP_ANGLE_LIMIT: f64 = 0.35;
/// The ratio of the second correction to the first that step control aims at \[-\]: a fifth of [`STEP_CONTRACTION_LIMIT`]. The ratio goes
/// like the square of the step, so the next step is longer by the root of what is missing.
pub(crate) const USUAL_STEP_CONTRACTION: f64 = 0.1;
/// The angle between the tangents at both ends of a step that step control aims at \[rad\].
pub(crate) const USUAL_STEP_ANGLE: f64 = 0.15;
/// The factors by which a step may differ from the one before it \[-\].
pub(crate) const STEP_GROWTH: std::ops::RangeInclusive<f64> = 0.25..=2.0;
/// A branch has closed if the tangent has this cosine or more with that at its first point \[-\]. It is below the cosine of
/// [`STEP_ANGLE_LIMIT`], so that the turn of one step does not hide a return.
pub(crate) const CLOSED_BRANCH_DIRECTION: f64 = 0.9;
/// A step is refused if the phase of an instant moves by more than this \[rad\] (theory 19); without forcing, its time in units of the
/// first motion's.
pub(crate) const STEP_PHASE_SHIFT: f64 = 0.5;
/// A step no longer than this arclength \[-\] is not divided any more where multipliers cross the unit circle that no bifurcation
/// explains, or where another branch is close (theory 19). It is a thousand times the smallest step by default.
pub(crate) const UNDIVIDED_STEP_LENGTH: f64 = 1e-5;
/// A motion that has grown beyond this many of its units gets units of its own \[-\]; smaller growth leaves scaled unknowns of order one.
pub(crate) const OUTGROWN_UNITS: f64 = 4.0;
/// A range narrower than this part of its largest number is taken as so wide \[-\]. Differences go by [`PARAMETER_STEP`] of it: of less
/// they would have fewer than seven digits.
pub(crate) const NARROW_RANGE: f64 = 1e-3;
/// The step of a central difference by the parameter, in parts of the range or of the number itself, whichever is smaller \[-\]: the
/// third root of the rounding of a double, which makes truncation and rounding alike.
pub(crate) const PARAMETER_STEP: f64 = 6e-6;
/// A number smaller than this part of its range counts as so large where the step of a difference goes by its size \[-\]: at zero there
/// would be no step.
pub(crate) const PARAMETER_SIZE_FLOOR: f64 = 1e-3;

/// A point is corrected when the last correction is no longer than this arclength \[-\]: it is applied with the equations before it,
/// which it changes in second order, below rounding.
pub(crate) const LAST_CORRECTION_LENGTH: f64 = 1e-10;
/// The mismatch of a loop that the last correction is to leave, in parts of the motion \[-\]: below the margin with which the rules of
/// contact are applied.
pub(crate) const SHARP_MISMATCH: f64 = 0.1 * ORBIT_MARGIN;
/// A correction that is longer than this part of the one before comes no nearer \[-\]: what is left is rounding, as near a regular point
/// corrections shrink faster.
pub(crate) const CORRECTION_NO_SHORTER: f64 = 0.5;
/// A closed loop counts as a point of the branch after all corrections if the last one was no longer than this arclength \[-\]: where
/// branches cross the equations determine a point to the root of [`ORBIT_CLOSED`] only.
pub(crate) const CROSSING_CORRECTION: f64 = 1e-6;
/// The ratio of two corrections counts if the first is longer than this arclength \[-\]: the second, its square, is rounding otherwise.
pub(crate) const ROUNDED_CORRECTION: f64 = 1e-8;
/// A loop that keeps its energy may be open up the slope of the energy by this part of the direction that leads to it \[-\]; more says
/// that motions beside it lose or gain energy. It is what differences by [`PARAMETER_STEP`] leave, with room to spare.
pub(crate) const ENERGY_OPENING: f64 = 1e-6;
/// A motion that keeps its energy has come to rest when its largest velocity is below this part of the unit of velocities \[-\]; no
/// derivation is known, tests/branch holds with it.
pub(crate) const BRANCH_AT_REST: f64 = 1e-4;
/// From this number of coordinates on a linear scene is followed by its impulses and their times (theory 19, "Many modes"); below, the
/// unknowns of a loop are few as well.
pub(crate) const MANY_MODES: usize = 24;
/// Singular values below this part of the largest entry belong to a direction along which a loop of impulses is not polished \[-\]: along
/// a fold it would move by rounding divided by them.
pub(crate) const SINGULAR_ALONG_FOLD: f64 = 1e-6;

/// A zero of a test function is located when the parameter moves by no more than this part of its range from one evaluation to the next
/// \[-\] (theory 19).
pub(crate) const ZERO_PARAMETER_CHANGE: f64 = 1e-12;
/// The search for a zero is over when the bracket is no longer than this part of the step \[-\].
pub(crate) const ZERO_BRACKET_LENGTH: f64 = 1e-13;
/// A value of a test function is small below this part of those at the ends of the step \[-\]; larger, a parameter that stands still (at
/// a fold) tells nothing about the zero.
pub(crate) const ZERO_VALUE: f64 = 1e-6;
/// A bifurcation that is known no better than this part of the range is looked for by interpolation as well \[-\]: a hundred times what a
/// regular one is known to, [`ZERO_PARAMETER_CHANGE`].
pub(crate) const WELL_LOCATED_BIFURCATION: f64 = 1e-10;
/// How far from a branch point, in arclength, the points lie between which it is interpolated \[-\] (theory 19): a polynomial through
/// eight of them is good to 1e-11 where functions change over lengths of 0.2.
pub(crate) const INTERPOLATION_REACH: f64 = 0.015;
/// An interpolated zero is known well if its error is no more than this part of the range \[-\]; else points are taken from half as far.
pub(crate) const INTERPOLATED_ZERO_ERROR: f64 = 1e-11;
/// A branch point with a larger error, in parts of the range, may be none but two branches that come close \[-\]: a hundred times
/// [`INTERPOLATED_ZERO_ERROR`].
pub(crate) const LOOSE_BRANCH_POINT: f64 = 1e-9;
/// A multiplier is at a number if it is nearer to it than this \[-\]: it is there but for how fast it changes with the parameter, and the
/// test is to tell it from points at which the equations are singular for every multiplier.
pub(crate) const MULTIPLIER_AT_NUMBER: f64 = 0.5;
/// A pair of multipliers is on the unit circle at a torus if the logarithm of its modulus is below this \[-\]: as [`MEETING`], what
/// multipliers are known to that meet.
pub(crate) const TORUS_ON_CIRCLE: f64 = 1e-6;

/// A boundary is located when it lies between points no farther apart than this arclength \[-\], on a branch and on a curve: loops close
/// to [`ORBIT_CLOSED`], and nearer points are not told apart.
pub(crate) const BRANCH_BOUNDARY_LENGTH: f64 = 1e-11;
/// The first contact that is looked for behind a touch lasts for this part of the period \[-\] (theory 22), or for less, down to
/// [`LEAST_BRIEF_CONTACT`]: what is neglected in its guess goes by the square.
pub(crate) const BRIEF_CONTACT: f64 = 0.02;
/// The shortest contact that is looked for behind a touch, in parts of the period \[-\]: the directions of its two instants differ by as much.
pub(crate) const LEAST_BRIEF_CONTACT: f64 = 1e-6;
/// A touch is that of a contact which comes to an end if it is no farther than this part of the range from where it is expected \[-\], or than
/// the way to that; no derivation is known, tests/branch holds with it.
pub(crate) const TOUCH_BESIDE: f64 = 1e-6;
/// The first point behind a touch at which a contact came to its end is so far from it along the branch \[-\]: a touching orbit itself has no
/// multipliers where these jump.
pub(crate) const TOUCH_LEFT: f64 = 1e-3;
/// The first step of a search for a touch along a branch \[-\], where none is expected.
pub(crate) const TOUCH_SECANT_STEP: f64 = 1e-4;
/// A stop is passed at a touch of it if the times differ by no more than this part of the period \[-\]; no derivation is known,
/// tests/branch holds with it.
pub(crate) const BREACH_AT_TOUCH: f64 = 1e-3;
/// A rule is broken at an impact if the times differ by no more than this part of the period \[-\]; no derivation is known, tests/branch
/// holds with it.
pub(crate) const BREACH_AT_IMPACT: f64 = 1e-3;
/// A stop is reached at the instant of another's impact if the times differ by no more than this part of the period \[-\]; no derivation
/// is known, tests/branch holds with it.
pub(crate) const REACHED_AT_IMPACT: f64 = 1e-7;
/// An impact below this part of the unit of velocities has no speed left if it is half as fast on the other side of the boundary \[-\]: a
/// gap goes by the square of the speed, and 1e-14 is its rounding.
pub(crate) const LOST_IMPACT_SPEED: f64 = 1e-7;
/// An impact below this part of the unit of velocities has a speed that is rounding \[-\].
pub(crate) const ROUNDED_IMPACT_SPEED: f64 = 1e-12;
/// What a landing border is known to by a stop that is passed, in parts of the range \[-\]: the passage goes by the third power of the
/// acceleration, and the third root of [`ORBIT_MARGIN`] is 6e-5.
pub(crate) const CUBIC_LANDING_ERROR: f64 = 1e-4;
/// A border at which a flight has no duration left is taken for a boundary that is found up to this part of the range before it \[-\], as
/// short flights break rules by rounding; no derivation is known, tests/branch holds with it.
pub(crate) const BORDER_BY_ROUNDING: f64 = 1e-5;
/// A border is looked for no farther than this part of the range from the last point \[-\], from where it is extrapolated by secants or
/// by a power law.
pub(crate) const BORDER_REACH: f64 = 1e-2;
/// A flight from a stop back to it may end at a border if it takes less than this part of the period \[-\]; whether it does is decided by
/// [`BORDER_REACH`].
pub(crate) const SHORT_FLIGHT_BACK: f64 = 0.05;
/// A flight or a stick shorter than this part of the period is one that has no duration left at a border \[-\]: a flight after a release
/// is followed no farther. It goes like the root of the distance from its border: about 1e-6 of the range is left then.
pub(crate) const VANISHING_DURATION: f64 = 1e-3;
/// The first step of the secants to a border, in parts of the range \[-\]; their error is of second order in it.
pub(crate) const BORDER_SECANT_STEP: f64 = 1e-6;
/// Sticks shorter than this part of the period are not extrapolated to a chatter border \[-\]: the completion of the chatter makes their
/// rounding (theory 19, "Chatter border").
pub(crate) const KNOWN_STICK: f64 = 1e-4;
/// An extrapolated border is known no better than this part of the range \[-\], however little the extrapolation changes; no derivation
/// is known, tests/branch holds with it.
pub(crate) const EXTRAPOLATION_ERROR: f64 = 3e-9;
/// All impacts of the period vanish if the fastest has no more than this part of the unit of velocities \[-\], where the law of their end
/// (theory 19, "Vanishing impacts") holds well enough to be extrapolated.
pub(crate) const VANISHING_IMPACT_SPEED: f64 = 0.02;
/// Impacts vanish without the contact after them if that lasts for this part of the period at least \[-\]; a shorter one comes to its own
/// border.
pub(crate) const VANISHING_IMPACT_STICK: f64 = 0.01;
/// Impacts slower than this part of the unit of velocities are not extrapolated \[-\]: their speeds have too few digits, as at
/// [`LOST_IMPACT_SPEED`].
pub(crate) const KNOWN_IMPACT_SPEED: f64 = 1e-7;
/// The half width of the time about a rise in which the contact force is looked at for its least value, in parts of the contact's
/// duration \[-\]; no derivation is known, tests/branch holds with it.
pub(crate) const RELEASE_ONSET_WINDOW: f64 = 0.2;
/// The step of the second difference of the acceleration at its largest, in parts of the contact's duration \[-\]: its rounding is 1e-10,
/// its truncation 1e-6, and it is the guess of a flight's length only.
pub(crate) const ONSET_CURVATURE_STEP: f64 = 1e-3;
/// The step of the difference that gives the rate of an acceleration after a landing, in parts of the time to the next instant \[-\]; it
/// is the guess of a duration only.
pub(crate) const LANDING_RATE_STEP: f64 = 1e-4;
/// Grazes accumulate if the ratio of their distances is that of bounces that just come to rest, to this part of what the ratio has above
/// 1 \[-\]; no derivation is known, tests/branch holds with it.
pub(crate) const ACCUMULATION_FACTOR_MATCH: f64 = 0.2;
/// A gap no larger than this part of the motion is a touch at a graze that is extrapolated \[-\]: half of what the rules of contact see.
pub(crate) const ACCUMULATING_GRAZE_GAP: f64 = 0.5 * ORBIT_MARGIN;
/// Grazes no farther from each other than this part of the range are the last of a sequence \[-\]: they are known no better themselves.
pub(crate) const NEAREST_GRAZES: f64 = 1e-10;

/// How far beside a branch an orbit of another is looked for at first, and how far a corrected one may be from its guess, in arclength
/// \[-\] (theory 19, "Switching").
pub(crate) const ASIDE_LENGTH: f64 = 0.01;
/// The speed of an impact that is born, in the unit of velocities \[-\] (theory 19, "Switching").
pub(crate) const BORN_IMPACT_SPEED: f64 = 1e-3;
/// The step along a branch by which the growth of a speed or of a flight from zero is measured, in arclength \[-\], short enough that
/// both grow in proportion to it.
pub(crate) const BORN_IMPACT_STEP: f64 = 1e-5;
/// How far past a corner, in arclength, its two impacts are exchanged \[-\].
pub(crate) const PAST_CORNER_LENGTH: f64 = 1e-4;
/// How far beyond a boundary an orbit is looked for, in parts of the range \[-\]; a tenth of it and less where another boundary is as
/// near.
pub(crate) const BEYOND_BOUNDARY_DISTANCE: f64 = 1e-4;
/// The factor from one distance beyond a boundary to the next \[-\].
pub(crate) const NEARER_BOUNDARY_FACTOR: f64 = 0.1;
/// How far beyond a boundary virtual orbits are followed before others are made of them, in arclength \[-\]; half of it and less where
/// that leads past another boundary.
pub(crate) const BEYOND_BOUNDARY_LENGTH: f64 = 1e-2;
/// Rounds in which a motion settles beyond a boundary: a deviation that is half as large after each is 1e-9 of itself.
pub(crate) const SETTLING_ROUNDS: usize = 30;
/// An orbit meets the branch at a boundary if its distance from the last orbit shrinks to this part or less with each tenth of the
/// distance from the boundary \[-\]: regular ones shrink to 0.1, those at a graze to the root of that, 0.32.
pub(crate) const NEARING_FACTOR: f64 = 0.6;
/// How many orbits in a row have to come nearer by [`NEARING_FACTOR`]: two may for another reason, as those beyond a fold next to the
/// boundary do.
pub(crate) const NEARING_IN_A_ROW: usize = 3;
/// An orbit farther from the last one of a branch than this part of its largest coordinate is another's \[-\].
pub(crate) const MEETS_BRANCH_DISTANCE: f64 = 0.1;
/// Orbits that differ by less than this part of the largest coordinate are one \[-\]: their distances need not shrink.
pub(crate) const SAME_AS_BRANCH: f64 = 1e-9;
/// The first step of the secants from the mean of two rounds to the doubling at which they are one, in arclength \[-\].
pub(crate) const DOUBLING_SECANT_STEP: f64 = 1e-6;
/// A step of these secants no longer than this arclength is the last \[-\].
pub(crate) const DOUBLING_LAST_STEP: f64 = 1e-12;
/// Steps of these secants as short as this arclength are rounding where they become no shorter \[-\], which ends the search where the
/// determinant has fewer digits than [`DOUBLING_LAST_STEP`] asks for.
pub(crate) const DOUBLING_STEP_ROUNDING: f64 = 1e-8;
/// The end of a doubled branch lies no farther from the point before it than this part of the step \[-\]; farther away is another
/// doubling.
pub(crate) const DOUBLING_END_REACH: f64 = 1.5;

/// A loop that misses closing by more than this part of its size at the two numbers of a curve is not one of that scene \[-\]. It is
/// larger than [`ELSEWHERE`] as the numbers of a special point are known better than its orbit.
pub(crate) const ELSEWHERE_ON_CURVE: f64 = 1e-4;
/// A stop is hit at a corner if one of its impacts is no farther from it than this part of the period \[-\]; else it is reached where
/// another is hit.
pub(crate) const HIT_AT_CORNER: f64 = 1e-6;
/// The step of the differences of a curve's condition by each scaled unknown \[-\]: as [`PARAMETER_STEP`].
pub(crate) const CONDITION_STEP: f64 = 6e-6;
/// The step of the slope of a determinant by the multiplier \[-\]: of fourth order, it leaves 1e-12 of truncation and as much rounding.
pub(crate) const MULTIPLIER_SLOPE_STEP: f64 = 1e-3;
/// An impact below this part of the unit of velocities makes a point of a curve one of a resonant graze \[-\]: all determinants of
/// multipliers vanish there with the speed.
pub(crate) const RESONANT_GRAZE_SPEED: f64 = 1e-5;
/// A test function that is larger than this part of its value before the point jumps there and has no zero \[-\]: another pair of
/// multipliers is the nearest to the circle from there on.
pub(crate) const TEST_FUNCTION_JUMP: f64 = 1e-2;
/// A curve of folds has a cusp where both numbers change by no more than this part of what they do beside it \[-\].
pub(crate) const CUSP_RATE: f64 = 1e-4;
/// A rule that is broken within this arclength of another special point of a curve is broken by what happens there \[-\].
pub(crate) const SAME_CURVE_POINT: f64 = 1e-6;
/// A stop that is passed by no more than this part of the unit of positions is not seen to be, on a curve \[-\]: as
/// [`INTEGRATED_MARGIN`].
pub(crate) const SHALLOW_PASSAGE: f64 = 1e-10;

// --- Families: sweep, attractor, basin.

/// The longest period that a bifurcation diagram tells, in periods of the forcing, or in points where the forcing has none: above it a
/// motion counts as one that does not repeat itself. Half of the sampled periods
/// is a limit too, 25 by default.
pub(crate) const DIAGRAM_LONGEST_PERIOD: usize = 32;
/// The first span, in the scene's unit of time, of a run that is to end after a number of impacts. It is doubled until they have come, so
/// that it is to be shorter than what any scene takes between two; where none come, the run ends after such a power of two of it.
pub(crate) const FIRST_COUNTED_SPAN: f64 = 1e-6;
/// Steps and evaluations of gaps, the second half of the span free of impacts, after which a run without a forcing period counts as one
/// without further impacts.
pub(crate) const QUIET_EVALUATIONS: usize = 20_000;
/// The ratio of its span to the time of its last impact above which the same is said of a run.
pub(crate) const QUIET_SPAN_RATIO: f64 = 1e4;
/// The longest period, in periods of the forcing, that a motion is tested for in the first windows, and up to which one far away counts as
/// drifting instead of lost: the default of the longest period that is asked for.
pub(crate) const FIRST_SOUGHT_PERIODS: usize = 32;
/// An orbit is one of a family, which attracts nothing, if its largest multiplier has this modulus or more: one, to what multipliers
/// that meet are known to, see [`MEETING`].
pub(crate) const NEUTRAL_MULTIPLIER: f64 = 1.0 - 1e-6;
/// States, one in each period of the forcing, that stand for a set, such as chaos or a torus; a motion that repeats itself within half as
/// many is an orbit.
pub(crate) const SET_STATES: usize = 1000;
/// How often two motions are carried on to twice as many states at most, where these do not tell whether their sets are one: to 32 000.
pub(crate) const MOST_SET_DOUBLINGS: usize = 5;
/// How often at least before two sets count as two, though each motion has come back to where it was: to 4000 states, since a motion may
/// visit parts of its set rarely.
pub(crate) const SET_DOUBLINGS_APART: usize = 2;
/// The last states of a motion on a set by which it is told whether it has come to an orbit instead: three rounds of half of
/// [`SET_STATES`], and four as in every window.
pub(crate) const ORBIT_CHECK_STATES: usize = 1504;
/// Rounds for which a motion must follow an orbit before it is labelled by it, unless other hits are asked for.
pub(crate) const ORBIT_ROUNDS_TO_LABEL: usize = 3;
/// Periods of the forcing for which a motion must stay on a set before it is labelled by it, unless other hits are asked for.
pub(crate) const SET_PERIODS_TO_LABEL: usize = 20;
/// The largest distance, in parts of the box, at which a motion counts as being at a point of an orbit.
pub(crate) const ATTRACTOR_RADIUS: f64 = 1e-2;
/// The same in parts of the least distance to a point of another attractor: what is near two attractors is near neither.
pub(crate) const OTHER_ATTRACTOR_PART: f64 = 0.2;
/// The same in parts of the least distance of two points of the orbit itself: below a half, so that a motion is near one of them at most.
pub(crate) const OWN_POINT_PART: f64 = 0.4;
/// Periods of the forcing in a row that a motion must be as far from the box as [`FAR`] says before it is labelled as lost: a motion that
/// is far away for a moment may come back.
pub(crate) const PERIODS_LOST: usize = 10;

// --- Beyond a boundary of a branch, by simulations (theory 19, "Grazing").

/// How far beyond a boundary a motion is looked for, in parts of the range \[-\].
pub(crate) const SIMULATED_DISTANCE: f64 = 1e-3;
/// By how much a motion beyond a boundary is kicked off the last orbit, in parts of its sizes \[-\]: far above rounding, and far below what
/// a motion differs by that does not come back.
pub(crate) const KICK_SIZE: f64 = 1e-6;
/// The size of a coordinate of which kicks are parts is no less than this part of the largest, and this number \[-\], \[units of q and v\]:
/// one that stays at zero is kicked too.
pub(crate) const KICKED_SIZE_PART: f64 = 1e-3;
/// See [`KICKED_SIZE_PART`].
pub(crate) const KICKED_SIZE_FLOOR: f64 = 1e-12;
/// The box in which a kicked motion is looked for, in its sizes \[-\].
pub(crate) const KICKED_BOX: f64 = 10.0;
/// The factor by which a simulation begins nearer to a boundary each time \[-\].
pub(crate) const NEARER_START_FACTOR: f64 = 0.1;
/// How many starts in a row say whether what they come to nears the last orbit.
pub(crate) const NEARING_STARTS: usize = 3;
/// A simulation begins no nearer to a boundary than so many of its errors \[-\].
pub(crate) const BOUNDARY_ERRORS: f64 = 10.0;
/// A motion goes on beyond a boundary if its distance from the last orbit shrinks to this part or less from one start to the next but one,
/// a hundred times nearer to the boundary \[-\]: to 0.1 where it goes like the root.
pub(crate) const WHOLE_NEARING: f64 = 0.3;
/// The same at each start: to 0.32 where it goes like the root.
pub(crate) const EACH_NEARING: f64 = 0.6;
/// A motion jumps at a boundary if of its distances from the last orbit the least is at least this part of the largest \[-\].
pub(crate) const JUMP_KEEPS: f64 = 0.5;
/// A motion that is so many times farther from the last orbit after twice as many periods has not settled \[-\].
pub(crate) const LEAVING_FACTOR: f64 = 2.0;
/// Distances from the last orbit below this part of its size are the kick that is left \[-\]: ten times [`KICK_SIZE`].
pub(crate) const KICK_LEFT: f64 = 1e-5;
