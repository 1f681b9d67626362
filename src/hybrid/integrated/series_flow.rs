//! Free motion of a pendulum along its Taylor series from one time to another, with first-order deviations of its start (theory 8).

use super::pendulum::{has_series, links_of, series_order};
use super::series::SeriesArc;
use crate::error::{Error, Result};
use crate::flow::steps::Tolerance;
use crate::flow::{
    BatchMotion, PendulumSeries, SeriesOf, SeriesTangents, TANGENT_LANES, TangentLanes,
};
use crate::model::{Moment, Scene};
use crate::tolerance::SINE_TURN;
use nalgebra::{DMatrix, DVector};

/// Steps before a span counts as too long to integrate. [work]
const MOST_SERIES_STEPS: usize = 50_000;

/// Free motion of a pendulum.
#[derive(Debug, Clone)]
pub(crate) struct SeriesFlow {
    pendulum: PendulumSeries,
}

/// The motion on one step of a flight.
#[derive(Debug, Clone)]
pub(crate) struct SeriesPiece {
    /// Its start, counted from that of the flight.
    pub start: f64,
    pub h: f64,
    n: usize,
    series: SeriesOf<1>,
}

impl SeriesPiece {
    /// The motion on it.
    pub fn motion(&self) -> BatchMotion<'_, 1> {
        self.series.motion(0)
    }

    /// The state a time after its start.
    pub fn state(&self, local: f64) -> Vec<f64> {
        let mut x = vec![0.0; 2 * self.n];
        self.series.state(local, &mut x);
        x
    }

    /// The same as an arc of a path.
    pub fn arc(&self) -> SeriesArc<'_> {
        SeriesArc {
            series: &self.series,
            n: self.n,
            span: self.h,
        }
    }
}

impl SeriesFlow {
    /// The free motion of a scene by series for a tolerance and coarser ones; none where it has no series, or follows signals.
    pub fn new(scene: &Scene, tolerance: Tolerance) -> Option<Self> {
        let links = links_of(scene.system()).filter(|_| has_series(scene))?;
        let excitation = scene.excitation();
        if !excitation.signals.is_empty() {
            return None;
        }
        let order = series_order(tolerance.relative);
        Some(Self {
            pendulum: PendulumSeries::new(links, &excitation, order),
        })
    }

    /// Carries a state over a span, and multiplies deviations from it by the Jacobian of that.
    pub fn flow(
        &self,
        tolerance: Tolerance,
        (at, span): (Moment, f64),
        state: &mut DVector<f64>,
        deviations: &mut DMatrix<f64>,
    ) -> Result<()> {
        let n = state.len() / 2;
        let moving: Vec<usize> = (0..deviations.ncols())
            .filter(|&j| deviations.column(j).amax() > 0.0)
            .collect();
        let groups: Vec<&[usize]> = moving.chunks(TANGENT_LANES).collect();
        let mut tangents = SeriesTangents::new(n, groups.len(), self.pendulum.coefficients());
        let order = self.order();
        self.along(tolerance, (at, span), state, |series, wanted| {
            let entry = |group: usize, row: usize| -> TangentLanes {
                let columns = groups[group];
                std::array::from_fn(|m| columns.get(m).map_or(0.0, |&j| deviations[(row, j)]))
            };
            tangents.expand(series, |group, i| [entry(group, i), entry(group, n + i)]);
            let most = tangents.last_terms(wanted, order);
            let part = (tolerance.relative / most).powf(1.0 / order as f64);
            let h = wanted * part.min(1.0);
            for (group, columns) in groups.iter().enumerate() {
                tangents.at(group, (h, order), |i, [q, v]| {
                    for (m, &j) in columns.iter().enumerate() {
                        (deviations[(i, j)], deviations[(n + i, j)]) = (q[m], v[m]);
                    }
                });
            }
            h
        })
    }

    /// The motion from a state over a span, step by step.
    pub fn pieces(
        &self,
        tolerance: Tolerance,
        span: (Moment, f64),
        state: &DVector<f64>,
    ) -> Result<Vec<SeriesPiece>> {
        let (mut state, mut start) = (state.clone(), 0.0);
        let n = state.len() / 2;
        let mut pieces = Vec::new();
        self.along(tolerance, span, &mut state, |series, h| {
            let series = series.clone();
            pieces.push(SeriesPiece {
                start,
                h,
                n,
                series,
            });
            start += h;
            h
        })?;
        Ok(pieces)
    }

    /// A piece of no length at a state, without acceleration.
    pub fn instant(&self, state: &DVector<f64>) -> SeriesPiece {
        let mut series: SeriesOf<1> = self.pendulum.room();
        let n = state.len() / 2;
        for i in 0..n {
            let (lane, own) = (&mut series.lanes[i / 2], i % 2);
            (lane.q[0][own], lane.v[0][own]) = ([state[i]], [state[n + i]]);
            lane.q[1][own] = lane.v[0][own];
        }
        SeriesPiece {
            start: 0.0,
            h: 0.0,
            n,
            series,
        }
    }

    /// The order of the velocities.
    pub fn order(&self) -> usize {
        self.pendulum.coefficients().order
    }

    /// Carries a state over a span in steps along its series; `go` is told how long a step may be, and says how long it is.
    fn along(
        &self,
        tolerance: Tolerance,
        (at, span): (Moment, f64),
        state: &mut DVector<f64>,
        mut go: impl FnMut(&SeriesOf<1>, f64) -> f64,
    ) -> Result<()> {
        let mut series = self.pendulum.room();
        let (mut done, mut before) = (0.0, None);
        for _ in 0..MOST_SERIES_STEPS {
            let left = span - done;
            if left <= 0.0 {
                return Ok(());
            }
            let (q, v) = state.as_slice().split_at(state.len() / 2);
            self.pendulum
                .begin(&mut series, 0, (at.after(done), q, v))?;
            self.pendulum.expand(&mut series);
            let motion = series.motion(0);
            let wanted = motion.longest_step(tolerance, before);
            if wanted.is_nan() {
                break;
            }
            // Gaps have the sines of the angles, which to the order of flights are known so far.
            let wanted = wanted.min(SINE_TURN / motion.largest(|lane| &lane.v[0]));
            let h = go(&series, wanted.min(left));
            if h.is_nan() || done + h == done {
                break;
            }
            if wanted.is_finite() {
                before = Some(wanted);
            }
            series.state(h, state.as_mut_slice());
            done = if h >= left { span } else { done + h };
        }
        Err(Error::NoConvergence {
            stage: "the integration of a flight",
            iterations: MOST_SERIES_STEPS,
            residual: span - done,
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::hybrid::{HybridMaps, IntegratedMaps};
    use crate::law::Regime;
    use crate::model::{BaseMotion, Forcing, Fourier, Harmonic, PendulumChain, Stop, System};
    use nalgebra::Complex;

    const TOLERANCE: Tolerance = Tolerance {
        relative: 2e-13,
        absolute: 1e-15,
    };

    fn forcings(n: usize) -> Vec<Forcing> {
        let force = DVector::from_fn(n, |i, _| Complex::new(0.7 - i as f64, 0.4));
        let base = BaseMotion::new(0.2, 1.7, 0.3).expect("valid");
        let harmonic = Harmonic::new(force.clone(), 2.3, -0.4).expect("valid");
        let several = Fourier::new(vec![force.clone(), force * Complex::i()], 1.1, 0.2);
        vec![
            Forcing::Unforced,
            base.into(),
            harmonic.into(),
            several.expect("valid").into(),
        ]
    }

    fn scene(n: usize, damper: f64, forcing: Forcing) -> Scene {
        let masses = DVector::from_fn(n, |i, _| 1.0 + 0.3 * i as f64);
        let lengths = DVector::from_fn(n, |i, _| 0.9 - 0.1 * i as f64);
        let dampers = DVector::from_element(n, damper);
        let chain = PendulumChain::new(masses, lengths, &dampers, 9.81).expect("valid");
        Scene::new(System::from(chain), forcing, Vec::<Stop>::new()).expect("valid")
    }

    fn start(n: usize) -> DVector<f64> {
        DVector::from_fn(2 * n, |i, _| {
            0.8 - 0.5 * (i % n) as f64 + 0.3 * (i / n) as f64
        })
    }

    #[test]
    fn a_flow_along_series_is_that_of_steps() {
        for n in 1..=5 {
            for (forcing, damper) in forcings(n).into_iter().zip([0.0, 0.1, 0.3, 0.0]) {
                let scene = scene(n, damper, forcing);
                let maps = IntegratedMaps::new(&scene, 0.9);
                // More columns than there are coordinates and velocities, or fewer, one of them without deviations.
                let columns = DMatrix::from_fn(2 * n, 6, |i, j| {
                    if j == 2 {
                        0.0
                    } else {
                        ((3 * i + 5 * j) % 7) as f64 - 2.5
                    }
                });
                let carried = |maps: &IntegratedMaps| {
                    let (mut x, mut deviations) = (start(n), columns.clone());
                    maps.flow(Regime::free(), (0.4, 1.1), &mut x, &mut deviations)
                        .expect("regular");
                    (x, deviations)
                };
                let ((x, dx), (y, dy)) = (carried(&maps), carried(&maps.clone().in_steps()));
                assert!(
                    (&x - &y).amax() < 1e-10 * x.amax(),
                    "{n} {:e}",
                    (x - y).amax()
                );
                assert!(
                    (&dx - &dy).amax() < 1e-7 * dx.amax(),
                    "{n} {:e}",
                    (dx - dy).amax()
                );
                assert_eq!(dx.column(2).amax(), 0.0);
            }
        }
    }

    /// In positions and momenta a motion without damping keeps volumes.
    #[test]
    fn volumes_change_with_the_determinant_of_the_mass_matrix() {
        for n in 1..=5 {
            for forcing in forcings(n) {
                let scene = scene(n, 0.0, forcing);
                let flow = SeriesFlow::new(&scene, TOLERANCE).expect("a pendulum");
                let (mut x, mut deviations) = (start(n), DMatrix::identity(2 * n, 2 * n));
                let at = Moment::new(0.0, 0.9, scene.frequency().unwrap_or(0.0));
                flow.flow(TOLERANCE, (at, 1.3), &mut x, &mut deviations)
                    .expect("regular");
                let mass = |x: &DVector<f64>| {
                    let System::PendulumChain(chain) = scene.system() else {
                        panic!("a chain")
                    };
                    let inertia = chain.links().inertia;
                    let entry = |i: usize, j: usize| inertia[(i, j)] * (x[i] - x[j]).cos();
                    DMatrix::from_fn(n, n, entry).determinant()
                };
                let wanted = mass(&start(n)) / mass(&x);
                let found = deviations.determinant();
                let rounding = 1e-12 * deviations.amax().powi(2);
                assert!(
                    (found - wanted).abs() < rounding * wanted,
                    "{n} {found} {wanted}"
                );
            }
        }
    }

    #[test]
    fn pieces_follow_each_other_and_end_where_the_flow_does() {
        let scene = scene(3, 0.1, forcings(3).remove(1));
        let flow = SeriesFlow::new(&scene, TOLERANCE).expect("a pendulum");
        let at = Moment::new(0.2, 0.9, 1.7);
        let pieces = flow
            .pieces(TOLERANCE, (at, 3.0), &start(3))
            .expect("regular");
        assert!(pieces.len() > 3);
        for pair in pieces.windows(2) {
            assert!((pair[0].start + pair[0].h - pair[1].start).abs() < 1e-14);
            let ends = [pair[0].state(pair[0].h), pair[1].state(0.0)];
            assert_eq!(ends[0], ends[1]);
        }
        let mut x = start(3);
        flow.flow(TOLERANCE, (at, 3.0), &mut x, &mut DMatrix::zeros(6, 0))
            .expect("regular");
        let last = &pieces[pieces.len() - 1];
        assert_eq!(x.as_slice(), last.state(last.h));
        assert!((last.start + last.h - 3.0).abs() < 1e-15);
        assert!(
            flow.pieces(TOLERANCE, (at, 0.0), &start(3))
                .expect("regular")
                .is_empty()
        );
    }

    #[test]
    fn what_leads_beyond_doubles_is_an_error() {
        let scene = scene(2, 0.1, Forcing::Unforced);
        let flow = SeriesFlow::new(&scene, TOLERANCE).expect("a pendulum");
        let mut x = DVector::from_vec(vec![0.1, 0.2, 1e200, 0.0]);
        let at = Moment::of_angle(0.0);
        let found = flow.flow(TOLERANCE, (at, 1.0), &mut x, &mut DMatrix::zeros(4, 0));
        assert!(found.is_err());
    }
}
