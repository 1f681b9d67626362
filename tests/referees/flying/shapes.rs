//! Gaps between a place of a flying body and a face, with their gradients and a true bound on their curvature.

use vibroimpact::{GapFunction, Result};

/// What bounds a place of a body.
#[derive(Debug, Clone, Copy)]
pub enum Face {
    /// Everything above a height.
    Floor {
        height: f64,
    },
    /// Everything outside a disc: the distance to it, or that of the squares, over the radius.
    Disc {
        centre: [f64; 2],
        radius: f64,
    },
    Squared {
        centre: [f64; 2],
        radius: f64,
    },
    /// Everything outside `|x/a|^p + |y/b|^p = 1` with p = 2 or 4, times the shorter half-axis.
    Oval {
        centre: [f64; 2],
        axes: [f64; 2],
        power: i32,
    },
}

/// A place of a body, by its coordinates q.
#[derive(Debug, Clone, Copy)]
pub enum Body {
    /// q = (x, y)
    Point,
    /// q = (y, angle): the end of an arm at an angle of its own, over x = 0.
    Upright { arm: f64, angle: f64 },
    /// q = (x, y, angle)
    Free { arm: f64, angle: f64 },
}

#[derive(Debug, Clone, Copy)]
pub struct Gap {
    pub body: Body,
    pub face: Face,
}

impl Body {
    pub fn n(self) -> usize {
        match self {
            Self::Point | Self::Upright { .. } => 2,
            Self::Free { .. } => 3,
        }
    }

    /// The coordinate that is an angle.
    pub fn turns(self) -> Option<usize> {
        match self {
            Self::Point => None,
            Self::Upright { .. } | Self::Free { .. } => Some(self.n() - 1),
        }
    }

    /// Where it is, and the derivatives of that by each coordinate.
    fn place(self, q: &[f64]) -> ([f64; 2], Vec<[f64; 2]>) {
        let turned = |arm: f64, angle: f64| {
            let (sin, cos) = angle.sin_cos();
            ([arm * cos, arm * sin], [-arm * sin, arm * cos])
        };
        match self {
            Self::Point => ([q[0], q[1]], vec![[1.0, 0.0], [0.0, 1.0]]),
            Self::Upright { arm, angle } => {
                let (off, by) = turned(arm, q[1] + angle);
                ([off[0], q[0] + off[1]], vec![[0.0, 1.0], by])
            }
            Self::Free { arm, angle } => {
                let (off, by) = turned(arm, q[2] + angle);
                let derivatives = vec![[1.0, 0.0], [0.0, 1.0], by];
                ([q[0] + off[0], q[1] + off[1]], derivatives)
            }
        }
    }

    fn arm(self) -> f64 {
        match self {
            Self::Point => 0.0,
            Self::Upright { arm, .. } | Self::Free { arm, .. } => arm,
        }
    }
}

fn away(p: [f64; 2], centre: [f64; 2]) -> [f64; 2] {
    [p[0] - centre[0], p[1] - centre[1]]
}

impl Face {
    fn gap(self, p: [f64; 2]) -> (f64, [f64; 2]) {
        match self {
            Self::Floor { height } => (p[1] - height, [0.0, 1.0]),
            Self::Disc { centre, radius } => {
                let d = away(p, centre);
                let r = d[0].hypot(d[1]);
                (r - radius, d.map(|d| d / r))
            }
            Self::Squared { centre, radius } => {
                let d = away(p, centre);
                let gap = (d[0] * d[0] + d[1] * d[1] - radius * radius) / radius;
                (gap, d.map(|d| 2.0 * d / radius))
            }
            Self::Oval {
                centre,
                axes,
                power,
            } => {
                let d = away(p, centre);
                let u = [d[0] / axes[0], d[1] / axes[1]];
                let size = axes[0].min(axes[1]);
                let gap = size * (u[0].abs().powi(power) + u[1].abs().powi(power) - 1.0);
                let slope = |k: usize| {
                    size * f64::from(power) * u[k].abs().powi(power - 1) * u[k].signum() / axes[k]
                };
                (gap, [slope(0), slope(1)])
            }
        }
    }

    /// Its shortest radius or half-axis.
    pub fn scale(self) -> f64 {
        match self {
            Self::Floor { .. } => f64::INFINITY,
            Self::Disc { radius, .. } | Self::Squared { radius, .. } => radius,
            Self::Oval { axes, .. } => axes[0].min(axes[1]),
        }
    }

    /// Bounds on the gradient and on the second derivative within a distance of the origin.
    fn bounds(self, reach: f64) -> [f64; 2] {
        match self {
            Self::Floor { .. } => [1.0, 0.0],
            // Steps to a contact may look a little beyond it.
            Self::Disc { radius, .. } => [1.0, 1.0 / (0.8 * radius)],
            Self::Squared { centre, radius } => {
                let far = reach + centre[0].hypot(centre[1]);
                [2.0 * far / radius, 2.0 / radius]
            }
            Self::Oval {
                centre,
                axes,
                power,
            } => {
                let size = axes[0].min(axes[1]);
                let far = (reach + centre[0].hypot(centre[1])) / size;
                let p = f64::from(power);
                // Of two entries, each of which is no larger.
                let slope = p * far.powi(power - 1) * 2f64.sqrt();
                [slope, p * (p - 1.0) * far.powi(power - 2) / size]
            }
        }
    }
}

impl Gap {
    pub fn value(&self, q: &[f64]) -> f64 {
        self.face.gap(self.body.place(q).0).0
    }

    pub fn slopes(&self, q: &[f64]) -> Vec<f64> {
        let (p, derivatives) = self.body.place(q);
        let (_, g) = self.face.gap(p);
        let along = derivatives.iter().map(|d| d[0] * g[0] + d[1] * g[1]);
        along.collect()
    }

    /// A bound on its curvature while its place stays within a distance of the origin: `D'H D + grad.D'`, where `|D|^2 <= 1 + arm^2`.
    pub fn curvature(&self, reach: f64) -> f64 {
        let [slope, bend] = self.face.bounds(reach);
        let arm = self.body.arm();
        bend * (1.0 + arm * arm) + slope * arm
    }
}

impl GapFunction for Gap {
    fn gap(&self, q: &[f64]) -> Result<f64> {
        Ok(self.value(q))
    }

    fn gradient(&self, q: &[f64], gradient: &mut [f64]) -> Result<()> {
        gradient.copy_from_slice(&self.slopes(q));
        Ok(())
    }
}
