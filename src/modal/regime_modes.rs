//! The modes of a linear scene in a regime (theory 22): while some stops are pressed, and others are held.

use crate::error::{Error, Result};
use crate::law::{ElementState, Regime};
use crate::linalg::rank;
use crate::modal::modes::{Modes, Spectrum, spectrum};
use crate::model::{Constraint, ContactGeometry, LinearSystem, Scene};
use crate::tolerance::DEPENDENT;
use nalgebra::DMatrix;

/// The modes of a linear scene while some stops are pressed, with their stiffness and damping, and others are held, with their gaps at
/// zero: shapes of shape `(n, m)`, of the m = n - k frequencies that k stops held with independent normals leave.
///
/// # Errors
/// As [`spectrum_in`]; `Error::OutOfMemory` for more modes than their shapes have room for.
///
/// # Examples
/// ```
/// use nalgebra::dmatrix;
/// use vibroimpact::{Forcing, LinearSystem, Scene, Spring, Stop, modes_in};
/// let system = LinearSystem::undamped(dmatrix![1.0], dmatrix![1.0])?;
/// let stop = Stop::new(0, 0.5, Spring::new(3.0, 0.0, None)?)?;
/// let scene = Scene::new(system, Forcing::Unforced, [stop])?;
/// assert!((modes_in(&scene, &[0], &[])?.natural_frequencies[0] - 2.0).abs() < 1e-15);
/// # Ok::<(), vibroimpact::Error>(())
/// ```
pub fn modes_in(scene: &Scene, pressed: &[usize], held: &[usize]) -> Result<Modes> {
    Modes::of(spectrum_in(scene, pressed, held)?)
}

/// The same without shapes, which are made when asked for.
///
/// # Errors
/// A scene that is not linear; a stop that does not exist, is named twice, or cannot be in that state; stops held that leave no motion;
/// `Error::NoConvergence` if an eigenvalue iteration fails.
pub fn spectrum_in(scene: &Scene, pressed: &[usize], held: &[usize]) -> Result<Spectrum> {
    let system = scene.linear_system("modes of a regime")?;
    let regime = regime_of(scene, pressed, held)?;
    if regime.is_free() {
        return spectrum(system);
    }
    let geometry = ContactGeometry::new(system, scene);
    let mass = system.mass().to_dense();
    let [stiffness, damping] = geometry.pressed(&regime).map(|added| &mass * added);
    let stiffness = system.stiffness().to_dense() + stiffness;
    let damping = system.damping().to_dense() + damping;
    if held.is_empty() {
        return spectrum(&LinearSystem::new(mass, damping, stiffness)?);
    }
    let (normals, reactions) = geometry.columns(regime.constrained());
    let free = rank::across(&normals)?;
    if free.ncols() == 0 {
        let value = format!("{held:?}");
        return Err(Error::bad_value("held", value, "these leave no motion"));
    }
    // What the contact forces, along M b, have no part in: the motions themselves, where reactions are those of inertia.
    let seen = rank::across(&(&mass * reactions))?;
    let part = |m: &DMatrix<f64>, by: &DMatrix<f64>| by.tr_mul(&(m * &free));
    let is_symmetric = free.tr_mul(&seen).singular_values().min() > 1.0 - DEPENDENT;
    let by = if is_symmetric { &free } else { &seen };
    let [own, damping, stiffness] = [&mass, &damping, &stiffness].map(|m| part(m, by));
    let reduced = if is_symmetric {
        LinearSystem::new(own, damping, stiffness)?
    } else {
        let inverse = rank::pseudo_inverse(&own, DEPENDENT * own.amax())?;
        let m = free.ncols();
        LinearSystem::new(
            DMatrix::identity(m, m),
            &inverse * damping,
            &inverse * stiffness,
        )?
    };
    Ok(spectrum(&reduced)?.lifted(&free))
}

/// The regime in which some stops are pressed and others held.
fn regime_of(scene: &Scene, pressed: &[usize], held: &[usize]) -> Result<Regime> {
    let mut regime = Regime::default();
    let (count, stops) = (scene.stops().len(), scene.stops());
    for (argument, given, state) in [
        ("pressed", pressed, ElementState::Pressed),
        ("held", held, ElementState::Held),
    ] {
        for &stop in given {
            let refused = |rule: String| Error::bad_value(argument, stop, rule);
            let law = stops.get(stop).map(Constraint::contact);
            let law = law.ok_or_else(|| refused(format!("the scene has {count} stops")))?;
            if !regime.leaves_free(stop) {
                return Err(refused("a stop is named once".to_owned()));
            }
            let is_possible = match state {
                ElementState::Pressed => law.by_state().force(state).is_some(),
                _ => law.may_hold(),
            };
            if !is_possible {
                let rule = format!("a stop with the law {} is never {argument}", law.name());
                return Err(refused(rule));
            }
            regime = regime.with(stop, state);
        }
    }
    Ok(regime)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::law::{ContactRelease, Spring};
    use crate::model::{Forcing, Reaction, Stop};
    use nalgebra::{dmatrix, dvector};

    fn scene(reaction: &Reaction) -> Scene {
        let system = LinearSystem::new(
            dmatrix![1.0, 0.2; 0.2, 0.7],
            dmatrix![0.1, -0.03; -0.03, 0.08],
            dmatrix![3.0, -1.0; -1.0, 2.0],
        );
        let law = Spring::new(200.0, 1.0, Some(ContactRelease::Gap)).expect("valid");
        let soft = Stop::new(dvector![0.6, -0.8], 1.0, law).expect("valid");
        let rigid = Stop::new(1, 1.0, 0.5).expect("valid");
        let stops = [soft, rigid.with_reaction(reaction.clone()).expect("valid")];
        Scene::new(system.expect("valid"), Forcing::Unforced, stops).expect("valid")
    }

    #[test]
    fn roots_of_a_pressed_regime_are_those_of_the_reference() {
        let modes = modes_in(&scene(&Reaction::Inertia), &[0], &[]).expect("modes");
        for (re, im) in [
            (-0.029_488_611_511_264_4, 1.243_854_025_683_34),
            (-0.914_450_782_428_13, 18.246_057_968_541_6),
        ] {
            let mut roots = modes.eigenvalues.iter();
            assert!(roots.any(|z| (z.re - re).abs() < 1e-13 && (z.im - im).abs() < 1e-12));
        }
    }

    #[test]
    fn a_stop_held_leaves_the_motion_along_it() {
        // The second coordinate is held: m1 = 1, c11 = 0.1, k11 = 3; with the soft stop pressed its share in k and c besides.
        for reaction in [Reaction::Inertia, Reaction::Coordinate] {
            let scene = scene(&reaction);
            for (pressed, k, c) in [(&[][..], 3.0, 0.1), (&[0], 3.0 + 72.0, 0.1 + 0.36)] {
                let modes = modes_in(&scene, pressed, &[1]).expect("modes");
                let shape = modes.shapes.column(0).map(|z| z.re.abs());
                assert!(shape[1] < 1e-14, "{shape}");
                // Held along its own coordinate alone a contact force moves the other, as by M^-1.
                if reaction == Reaction::Inertia {
                    assert!((modes.natural_frequencies[0] - f64::sqrt(k)).abs() < 1e-13);
                    assert!((modes.eigenvalues[0].re + 0.5 * c).abs() < 1e-13);
                    assert!((shape[0] - 1.0).abs() < 1e-14);
                }
            }
        }
    }

    #[test]
    fn states_that_a_stop_has_not_are_refused() {
        let scene = scene(&Reaction::Inertia);
        for (pressed, held, name) in [
            (&[1][..], &[][..], "pressed"),
            (&[], &[0], "held"),
            (&[2], &[], "pressed"),
            (&[0, 0], &[], "pressed"),
        ] {
            let error = spectrum_in(&scene, pressed, held).expect_err("refused");
            assert!(error.is_about(name), "{error}");
        }
    }
}
