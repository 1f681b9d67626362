//! `periodic_orbits`: from a scene and a pattern to every orbit, its verdict and its order.

use crate::error::Result;
use crate::model::{Parameter, Scene};
use crate::observer::Observer;
use crate::orbit::free_parameter::{free_forcing, free_parameter};
use crate::orbit::one_contact::solve::one_contact;
use crate::orbit::one_instant::solve::{
    at_clearance, at_phase, at_scaled_clearance, without_impacts,
};
use crate::orbit::options::{FreeParameter, OrbitOptions};
use crate::orbit::orbits::Orbits;
use crate::orbit::pattern::Pattern;
use crate::orbit::problem::{Problem, check, compliant_stops};
use crate::orbit::two_instants::solve::two_instants;

/// Every periodic orbit of a linear, forced scene that hits stops in the given pattern (theory 5).
///
/// With the clearances given (the default) the forcing phase at the first impact is found; with `options.phase` given,
/// the clearances of the stops in the pattern come out. Orbits that are not admissible are returned with their
/// violation, which is searched for when first asked for.
///
/// The list is in the order of [`Orbits`]: stable and admissible ones first; in systems of more than 60 degrees of freedom
/// admissible ones first, stable or not.
///
/// A pattern of two instants is searched in the flight time between them, every one of which is decided by bounds;
/// `Orbits::reason` says what was proved. One stop hit twice gives one orbit for each pair of flight times that add up to
/// the period, and none that is an orbit of half the period gone through twice. Flight times nearer to 0 or the period than
/// 1e-9 of it are not searched, no margin is reported, no free parameter is taken, and of undamped modes in step with the
/// period there may be four.
///
/// Of a stop that gives way every orbit is found that has one contact with it in the period, of two such stops, each the image of the other in
/// a scene that is odd, those that are their own images half a period later: by an equation in the duration of the contact, every one of
/// which is an orbit's or excluded by bounds. Stops of any law that are not met may stand by.
///
/// # Errors
/// A nonlinear or unforced scene, a pattern that does not fit it or has more than two instants, options that contradict
/// each other, a phase given for two instants without a common stop; of stops that give way patterns other than one contact, and one of each of
/// two that are each other's images; a motion that grows beyond the doubles within a period,
/// a period of more than 1e12 turns of the fastest mode, whose phase is lost.
///
/// # References
/// The source paper, eqs. (29) and (38), with the corrections of theory section 3.
///
/// # Examples
/// ```
/// use vibroimpact::{Kind, OrbitOptions, PaperOptions, Pattern, paper_scene, periodic_orbits};
/// let scene = paper_scene(Kind::Three, &PaperOptions::default())?;
/// let options = OrbitOptions { n_periods: 2, ..Default::default() };
/// let orbits = periodic_orbits(&scene, &Pattern::single(1), &options)?;
/// assert_eq!(orbits[0].is_admissible(), Some(true));
/// assert_eq!(orbits[0].stability()?.is_stable, Some(true));
/// # Ok::<(), vibroimpact::Error>(())
/// ```
pub fn periodic_orbits(scene: &Scene, pattern: &Pattern, options: &OrbitOptions) -> Result<Orbits> {
    let observer = &mut Observer::default();
    check(scene, pattern, options, "periodic_orbits")?;
    let problem = Problem::new(scene, pattern, options)?;
    if let Some(stops) = compliant_stops(scene, pattern, "periodic_orbits")? {
        let solutions = one_contact(&problem, &stops, observer)?;
        return Orbits::new(&problem, solutions, observer);
    }
    let solutions = match (pattern.instants(), options.phase, options.free) {
        ([], ..) => without_impacts(&problem)?,
        ([_], Some(phase), _) => at_phase(&problem, phase)?,
        ([_], None, None) => at_clearance(&problem)?,
        ([_], None, Some(FreeParameter::Clearance)) => at_scaled_clearance(&problem)?,
        ([_], None, Some(FreeParameter::Parameter(Parameter::ForcingScale))) => {
            return free_forcing(&problem, observer);
        }
        ([_], None, Some(FreeParameter::Parameter(parameter))) => {
            return free_parameter(&problem, parameter, observer);
        }
        _ => two_instants(&problem, observer)?,
    };
    Orbits::new(&problem, solutions, observer)
}
