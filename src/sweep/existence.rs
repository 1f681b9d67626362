//! Existence maps: over two parameters of a linear scene, whether a pattern of impacts has a periodic orbit, an admissible one, a stable
//! one (docs/theory.md, sections 5 to 7). A map has a point, also called a cell, for each pair of values; arrays are in rows of equal y,
//! x running fastest, and values in the units of their parameter: `Parameter` in `model/parameter.rs` lists what can vary.

use crate::error::{Error, Result};
use crate::flow::ModalScene;
use crate::model::{Parameter, Scene};
use crate::observer::{Observer, ProgressRange, report};
use crate::orbit::{
    OrbitOptions, Pattern, PeriodicConditions, Ruling, Solution, check, clearance_given,
    compliant_stops, decides, period, periodic_orbits, ranking,
};
use crate::quantity::room_for;
use crate::sweep::parametric_scene::ParametricScene;
use crate::sweep::tiles::{SweepOptions, fill};
use crate::sweep::unranked_orbit::{UnrankedOrbit, judge_all};
use std::ops::Range;

/// Grid points that a thread takes at a time. [work]
const EXISTENCE_TILE: usize = 256;

/// A parameter of a scene and the values that it takes on one axis of a map.
#[derive(Debug, Clone, PartialEq)]
pub struct Axis {
    /// What varies: `"frequency".parse()`, `"clearance[1]".parse()` and so on.
    pub parameter: Parameter,
    /// Its values, in any order, one at least, shape `(m,)`, \[unit of the parameter\].
    pub values: Vec<f64>,
}

impl Axis {
    /// An axis.
    pub fn new(parameter: Parameter, values: impl IntoIterator<Item = f64>) -> Self {
        Self {
            parameter,
            values: values.into_iter().collect(),
        }
    }
}

/// One point of an existence map: the orbits at one pair of values.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ExistencePoint {
    /// Number of orbits of the pattern, admissible or not.
    pub n_orbits: u32,
    /// Whether one of them is proved to be admissible.
    pub is_admissible: bool,
    /// Whether one of them is admissible and stable; of more than 60 degrees of freedom, whose orbits are not ordered by
    /// stability: whether the first one is.
    pub is_stable: bool,
    /// Largest modulus of the multipliers of the first orbit, in the order of [`Orbits`](crate::Orbits): stable and
    /// admissible ones first; nan where there is no orbit, or its return map has no derivative.
    pub multiplier: f64,
}

/// A pair of values without an orbit; also one whose motion the doubles do not hold.
const NO_ORBIT: ExistencePoint = ExistencePoint {
    n_orbits: 0,
    is_admissible: false,
    is_stable: false,
    multiplier: f64::NAN,
};

/// Where in a plane of two parameters a pattern has periodic orbits. Arrays over both have a value for each of the
/// `n_y * n_x` pairs, row by row, x running fastest.
#[derive(Debug, Clone, PartialEq)]
pub struct ExistenceMap {
    /// What x is, where it is a parameter of the scene.
    pub x_name: Option<String>,
    /// What y is, where it is a parameter of the scene.
    pub y_name: Option<String>,
    /// Values of x, shape `(n_x,)`, \[unit of x\].
    pub x: Vec<f64>,
    /// Values of y, shape `(n_y,)`, \[unit of y\].
    pub y: Vec<f64>,
    /// Number of orbits, shape `(n_y * n_x,)`.
    pub n_orbits: Vec<u32>,
    /// Whether one of them is admissible, shape `(n_y * n_x,)`.
    pub is_admissible: Vec<bool>,
    /// Whether one of them is admissible and stable, shape `(n_y * n_x,)`.
    pub is_stable: Vec<bool>,
    /// Largest modulus of the multipliers of the first orbit, nan where there is none, shape `(n_y * n_x,)`, \[-\].
    pub multiplier: Vec<f64>,
}

impl ExistenceMap {
    /// A map from its cells, row by row.
    ///
    /// # Errors
    /// `Error::BadShape` unless there is one cell for each pair of values.
    pub fn from_cells(
        (x_name, x): (Option<String>, Vec<f64>),
        (y_name, y): (Option<String>, Vec<f64>),
        cells: &[ExistencePoint],
    ) -> Result<Self> {
        if cells.len() != x.len() * y.len() {
            let needed = format!("({},): one for each pair of values", x.len() * y.len());
            return Err(Error::bad_shape(
                "cells",
                format!("({},)", cells.len()),
                needed,
            ));
        }
        Ok(Self {
            x_name,
            y_name,
            x,
            y,
            n_orbits: cells.iter().map(|c| c.n_orbits).collect(),
            is_admissible: cells.iter().map(|c| c.is_admissible).collect(),
            is_stable: cells.iter().map(|c| c.is_stable).collect(),
            multiplier: cells.iter().map(|c| c.multiplier).collect(),
        })
    }

    /// The point at `x[i]`, `y[j]`.
    ///
    /// # Panics
    /// If there is no such value.
    pub fn point(&self, i: usize, j: usize) -> ExistencePoint {
        assert!(i < self.x.len(), "x has {} values", self.x.len());
        let k = j * self.x.len() + i;
        ExistencePoint {
            n_orbits: self.n_orbits[k],
            is_admissible: self.is_admissible[k],
            is_stable: self.is_stable[k],
            multiplier: self.multiplier[k],
        }
    }
}

/// Map where in a plane of two parameters a pattern has a periodic orbit, an admissible one, a stable one.
///
/// Each pair of values is answered as by [`periodic_orbits`](crate::periodic_orbits) with the clearances given; where that
/// refuses because doubles do not hold the motion (it outgrows them within a period, or the period has more than 1e12 turns
/// of the fastest mode), the cell has no orbit. The observer of the calling
/// thread ([`with_observer`](crate::with_observer)) is told from time to time and at the end; breaking off stops every thread. The result
/// has the same bits on any number of threads.
///
/// # Errors
/// Before anything is computed: a scene or pattern that [`periodic_orbits`](crate::periodic_orbits) refuses, a value that
/// breaks the rule of its parameter, an axis without values, two axes that vary the same number. `Error::Interrupted` from the
/// observer;
/// `Error::NoConvergence` if an eigenvalue iteration fails.
///
/// # Examples
/// ```
/// use vibroimpact::{Axis, Kind, PaperOptions, Pattern, SweepOptions, existence_map, paper_scene};
/// let scene = paper_scene(Kind::Three, &PaperOptions::default())?;
/// let frequency = Axis::new("frequency".parse()?, [1.4, 1.5, 1.6]);
/// let clearance = Axis::new("clearance[1]".parse()?, [0.15, 10.0]);
/// let map = existence_map(&scene, &Pattern::single(1), (&frequency, &clearance), 2, SweepOptions::default())?;
/// assert_eq!(map.n_orbits, [2, 2, 2, 0, 0, 0]);
/// assert!(map.point(1, 0).is_stable);
/// # Ok::<(), vibroimpact::Error>(())
/// ```
pub fn existence_map(
    scene: &Scene,
    pattern: &Pattern,
    (x, y): (&Axis, &Axis),
    n_periods: usize,
    options: SweepOptions,
) -> Result<ExistenceMap> {
    // A point and its part of the arrays.
    let words = 2 * size_of::<ExistencePoint>() / size_of::<f64>();
    room_for(
        "an existence map",
        x.values.len().saturating_mul(words),
        y.values.len(),
    )?;
    let sweep = MapRequest::new(scene, pattern, x, y, n_periods)?;
    let mut cells = vec![NO_ORBIT; sweep.len()];
    let _range = ProgressRange::over(0.0, sweep.len() as f64);
    let item = |parametric: &mut ParametricScene<'_>, index| sweep.point(parametric, index);
    fill(
        &mut cells,
        EXISTENCE_TILE,
        options,
        || sweep.parametric_scene(),
        item,
    )?;
    let named = |axis: &Axis| (Some(axis.parameter.to_string()), axis.values.clone());
    ExistenceMap::from_cells(named(x), named(y), &cells)
}

/// Some cells of an existence map, on the calling thread: those of the given indices, `index = j * x.len() + i` for
/// `x[i]`, `y[j]`. Pieces put together are the map of [`existence_map`], bit by bit.
///
/// # Errors
/// As [`existence_map`]; a range that ends beyond the last cell.
pub fn existence_tile(
    scene: &Scene,
    pattern: &Pattern,
    (x, y): (&Axis, &Axis),
    n_periods: usize,
    cells: Range<usize>,
) -> Result<Vec<ExistencePoint>> {
    let sweep = MapRequest::new(scene, pattern, x, y, n_periods)?;
    if cells.end > sweep.len() {
        return Err(Error::bad_value(
            "cells",
            format!("{cells:?}"),
            format!("the map has {} cells", sweep.len()),
        ));
    }
    let mut parametric = sweep.parametric_scene()?;
    let _range = ProgressRange::over(cells.start as f64, cells.end as f64);
    cells
        .map(|index| {
            report(index as f64)?;
            sweep.point(&mut parametric, index)
        })
        .collect()
}

/// The point of an existence map that one scene stands for: for maps over anything that makes a scene.
///
/// # Errors
/// As [`periodic_orbits`](crate::periodic_orbits), but for motions that doubles do not hold: they count as no orbit.
pub fn existence_at(scene: &Scene, pattern: &Pattern, n_periods: usize) -> Result<ExistencePoint> {
    let options = OrbitOptions {
        n_periods,
        ..Default::default()
    };
    check(scene, pattern, &options, "existence_map")?;
    if is_one_instant(scene, pattern)? {
        let modal = ModalScene::new(scene, "existence_map")?;
        return one_instant(&modal, pattern, n_periods, &mut Observer::default());
    }
    let found = in_doubles(periodic_orbits(scene, pattern, &options))?;
    let Some((orbits, first)) = found.as_ref().and_then(|o| Some((o, o.first()?))) else {
        return Ok(NO_ORBIT);
    };
    let stability = first.stability()?;
    Ok(ExistencePoint {
        n_orbits: count(orbits.len()),
        is_admissible: first.is_admissible() == Some(true),
        is_stable: first.is_admissible() == Some(true) && stability.is_stable == Some(true),
        multiplier: stability
            .orders
            .first()
            .map_or(f64::NAN, crate::OrderMultipliers::spectral_radius),
    })
}

/// The result; `None` where doubles do not hold the motion: its values are refused although each was checked, or its equations
/// overflow.
fn in_doubles<T>(found: Result<T>) -> Result<Option<T>> {
    match found {
        Ok(found) => Ok(Some(found)),
        Err(Error::BadValue { .. }) => Ok(None),
        Err(Error::NoConvergence { residual, .. }) if residual.is_infinite() => Ok(None),
        Err(error) => Err(error),
    }
}

fn count(orbits: usize) -> u32 {
    u32::try_from(orbits).unwrap_or(u32::MAX)
}

/// The checked input of one existence map.
struct MapRequest<'a> {
    scene: &'a Scene,
    pattern: &'a Pattern,
    x: &'a Axis,
    y: &'a Axis,
    n_periods: usize,
}

impl<'a> MapRequest<'a> {
    fn new(
        scene: &'a Scene,
        pattern: &'a Pattern,
        x: &'a Axis,
        y: &'a Axis,
        n_periods: usize,
    ) -> Result<Self> {
        check(
            scene,
            pattern,
            &OrbitOptions {
                n_periods,
                ..Default::default()
            },
            "existence_map",
        )?;
        check_distinct(x.parameter, y.parameter)?;
        for (name, axis) in [("x", x), ("y", y)] {
            let Some(&first) = axis.values.first() else {
                return Err(Error::bad_shape(name, "(0,)", "one value at least"));
            };
            // Whether the scene has such a parameter does not depend on the value, if it is one that overflows nothing.
            let harmless = match axis.parameter {
                Parameter::Frequency | Parameter::ForcingScale | Parameter::DampingScale => 1.0,
                _ => first,
            };
            scene.replace(axis.parameter.change(harmless))?;
            axis.values
                .iter()
                .try_for_each(|&value| axis.parameter.check(value))?;
        }
        Ok(Self {
            scene,
            pattern,
            x,
            y,
            n_periods,
        })
    }

    fn len(&self) -> usize {
        self.x.values.len() * self.y.values.len()
    }

    fn parametric_scene(&self) -> Result<ParametricScene<'a>> {
        ParametricScene::new(self.scene, "existence_map")
    }

    fn point(&self, parametric: &mut ParametricScene<'_>, index: usize) -> Result<ExistencePoint> {
        let (i, j) = (index % self.x.values.len(), index / self.x.values.len());
        let (x, y) = (self.x.values[i], self.y.values[j]);
        if is_one_instant(self.scene, self.pattern)? {
            let values = [(self.x.parameter, x), (self.y.parameter, y)];
            let Some(scene) = in_doubles(parametric.at(&values))? else {
                return Ok(NO_ORBIT);
            };
            return one_instant(
                scene,
                self.pattern,
                self.n_periods,
                &mut Observer::default(),
            );
        }
        let moved = self.scene.replace(self.x.parameter.change(x));
        let moved = moved.and_then(|scene| scene.replace(self.y.parameter.change(y)));
        let Some(scene) = in_doubles(moved)? else {
            return Ok(NO_ORBIT);
        };
        existence_at(&scene, self.pattern, self.n_periods)
    }
}

/// Refuses two parameters that are one number, or overlap.
fn check_distinct(x: Parameter, y: Parameter) -> Result<()> {
    if x.overlaps(y) {
        return Err(Error::bad_value(
            "y",
            y,
            format!("x is {x}: the two must vary different numbers of the scene"),
        ));
    }
    Ok(())
}

/// Whether all that happens in a pattern is impacts at one instant.
fn is_one_instant(scene: &Scene, pattern: &Pattern) -> Result<bool> {
    let gives_way = compliant_stops(scene, pattern, "existence_map")?.is_some();
    Ok(pattern.instants().len() == 1 && !gives_way)
}

/// The point of a pattern of one instant, without building scenes or orbits.
fn one_instant(
    scene: &ModalScene,
    pattern: &Pattern,
    n_periods: usize,
    observer: &mut Observer,
) -> Result<ExistencePoint> {
    let Some(span) = in_doubles(period(scene, n_periods))? else {
        return Ok(NO_ORBIT);
    };
    let instant = PeriodicConditions::new(scene, &pattern.instants()[0], span);
    let Some(phases) = in_doubles(clearance_given(&instant))? else {
        return Ok(NO_ORBIT);
    };
    if phases.points.is_empty() {
        return Ok(NO_ORBIT);
    }
    let candidate = |solution| UnrankedOrbit::new(scene, solution);
    let mut candidates: Vec<UnrankedOrbit> = phases
        .points
        .iter()
        .map(|x| Ok(candidate(Solution::new(&instant, x, span)?)))
        .collect::<Result<_>>()?;
    if !candidates.iter().all(|c| c.solution.flight.is_finite()) {
        return Ok(NO_ORBIT);
    }
    judge_all(scene, &mut candidates, observer)?;
    if candidates.is_empty() {
        return Ok(NO_ORBIT);
    }
    let rulings: Vec<Ruling> = candidates.iter().map(UnrankedOrbit::ruling).collect();
    let is_stable = |radius: Option<f64>| radius.and_then(decides) == Some(true);
    let mut radius = |i: usize| candidates[i].largest_multiplier(scene, observer);
    let first = ranking(scene.form.n_dof(), &rulings, |i| Ok(is_stable(radius(i)?)))?[0];
    let (is_admissible, radius) = (rulings[first] == Ruling::Admissible, radius(first)?);
    Ok(ExistencePoint {
        n_orbits: count(candidates.len()),
        is_admissible,
        is_stable: is_admissible && is_stable(radius),
        multiplier: radius.unwrap_or(f64::NAN),
    })
}
