//! The return map of an orbit by plain matrices: flights by exponentials, contacts by Newton's method on the gap, impacts by
//! the plain law. Deviations of it against the multipliers, and its iterates against the verdict on stability.

use crate::orbits::closing::instants;
use crate::orbits::plant::{Face, Plant, exponential};
use nalgebra::{DMatrix, DVector};
use vibroimpact::PeriodicOrbit;

/// Newton steps to a contact.
const STEPS: usize = 12;

/// An orbit of single impacts as a map of the state just after its first impact, over one period.
pub struct Returns<'a> {
    plant: &'a Plant,
    big: DMatrix<f64>,
    /// The clearances that the orbit has.
    faces: Vec<Face>,
    /// The stops and times of the impacts after the first, and of the first a period later.
    hits: Vec<(usize, f64)>,
    flights: Vec<DMatrix<f64>>,
    phase: f64,
    period: f64,
}

impl<'a> Returns<'a> {
    /// The return map; `None` for an orbit without impacts, or with several at one instant.
    pub fn new(plant: &'a Plant, orbit: &PeriodicOrbit) -> Option<Self> {
        let mut found = instants(orbit);
        if found.is_empty() || found.iter().any(|(_, stops)| stops.len() != 1) {
            return None;
        }
        found.push((orbit.period(), found[0].1.clone()));
        let zero = DVector::zeros(plant.n());
        let gaps = orbit.scene().gaps(&zero).expect("linear");
        let own = |(face, &clearance): (&Face, &f64)| Face {
            clearance,
            ..face.clone()
        };
        let big = plant.enlarged();
        let spans = found.windows(2).map(|pair| pair[1].0 - pair[0].0);
        Some(Self {
            plant,
            faces: plant.faces.iter().zip(gaps.iter()).map(own).collect(),
            hits: found[1..].iter().map(|(t, stops)| (stops[0], *t)).collect(),
            flights: spans.map(|span| exponential(&(&big * span))).collect(),
            big,
            phase: orbit.phase(),
            period: orbit.period(),
        })
    }

    /// The state (q, v) a period later; `None` where a contact is not reached.
    pub fn map(&self, state: &DVector<f64>) -> Option<DVector<f64>> {
        let n = self.plant.n();
        let (q, v) = (state.rows(0, n).into_owned(), state.rows(n, n).into_owned());
        let mut x = self.plant.lifted(&q, &v, self.phase);
        let (mut time, mut usual) = (0.0, 0.0);
        for ((stop, at), flight) in self.hits.iter().zip(&self.flights) {
            let face = &self.faces[*stop];
            // The flight of the orbit's own span, from the orbit's own time.
            if time != usual {
                x = exponential(&(&self.big * (usual - time))) * x;
            }
            x = flight * x;
            (time, usual) = (*at, *at);
            let mut last = f64::INFINITY;
            for _ in 0..STEPS {
                let gap = face.clearance - face.normal.dot(&x.rows(0, n));
                let step = gap / face.normal.dot(&x.rows(n, n));
                if !step.is_finite() || step.abs() > 0.1 * self.period {
                    return None;
                }
                if step.abs() >= last {
                    break;
                }
                last = step.abs();
                x = exponential(&(&self.big * step)) * x;
                time += step;
            }
            let push = (1.0 + face.restitution) * face.normal.dot(&x.rows(n, n))
                / face.normal.dot(&face.reaction);
            let mut v = x.rows_mut(n, n);
            v -= &face.reaction * push;
        }
        x = exponential(&(&self.big * (self.period - time))) * x;
        Some(x.rows(0, 2 * n).into_owned())
    }

    /// The Jacobian of the map by central differences, in steps of a part of the given sizes of position and velocity.
    pub fn jacobian(
        &self,
        start: &DVector<f64>,
        sizes: [f64; 2],
        part: f64,
    ) -> Option<DMatrix<f64>> {
        let n = self.plant.n();
        let mut jacobian = DMatrix::zeros(2 * n, 2 * n);
        for j in 0..2 * n {
            let step = part * sizes[j / n];
            let moved = |step: f64| {
                let mut x = start.clone();
                x[j] += step;
                self.map(&x)
            };
            let column = (moved(step)? - moved(-step)?) / (2.0 * step);
            jacobian.set_column(j, &column);
        }
        Some(jacobian)
    }
}
