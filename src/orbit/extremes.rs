//! How far a motion goes and how near it comes to each stop, and where: at times at which a speed changes its sign, sought between the
//! points at which the motion is drawn, and at instants, where it may jump.

use crate::error::Result;
use crate::model::{Contact, Moment, Scene, contacts};
use crate::orbit::orbit_data::OrbitArc;
use crate::path::Path;
use crate::root::FalsePosition;
use crate::tolerance::{FIRST_BRACKET_PART, SAME_EXTREME, TOUCHED};

/// Steps on one extreme inside its bracket. [work]
const MOST_EXTREME_STEPS: usize = 80;

/// A place on an orbit: so far along a flight, in parts of its span.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct PlaceOnFlight {
    pub flight: usize,
    pub part: f64,
    /// -1 where the coordinate is at its lowest.
    pub sign: f64,
}

/// An extreme, and every place where it is reached; none where it is that of a contact.
#[derive(Debug, Clone)]
pub(crate) struct Extreme {
    pub value: f64,
    pub places: Vec<PlaceOnFlight>,
}

/// The extremes of an orbit.
#[derive(Debug, Clone)]
pub(crate) struct Extremes {
    /// The least gap of each stop.
    pub gaps: Vec<Extreme>,
    /// The largest distance of each coordinate from zero.
    pub displacements: Vec<Extreme>,
    /// A stop that is touched without an impact, or nearly so.
    pub touched: Option<usize>,
}

/// A quantity and its rate.
type ValueAndRate = [f64; 2];

/// The samples of a flight: how far along it, and every quantity there.
struct FlightSamples {
    flight: usize,
    local: Vec<f64>,
    values: Vec<Vec<ValueAndRate>>,
}

/// A maximum of a quantity: its value, where it is, and whether that is between two instants.
struct Maximum {
    value: f64,
    place: PlaceOnFlight,
    is_between: bool,
}

/// The motion whose extremes are sought: one period of an orbit, in the scene of its phase.
pub(crate) struct Along<'a> {
    pub scene: &'a Scene,
    pub path: &'a Path,
    pub flights: &'a [OrbitArc],
}

impl Extremes {
    pub fn new(along: &Along<'_>) -> Result<Self> {
        let contacts = contacts(along.scene);
        let quantities = OrbitQuantities {
            along,
            contacts: &contacts,
        };
        let sampled = quantities.sampled()?;
        let n = along.scene.n_dof();
        let mut displacements = Vec::with_capacity(n);
        for i in 0..n {
            let (up, size) = quantities.maxima(&sampled, i, 1.0)?;
            let (down, _) = quantities.maxima(&sampled, i, -1.0)?;
            displacements.push(largest(up.into_iter().chain(down), SAME_EXTREME * size));
        }
        let (mut gaps, mut touched) = (Vec::with_capacity(contacts.len()), None);
        for stop in 0..contacts.len() {
            let (maxima, size) = quantities.maxima(&sampled, n + stop, -1.0)?;
            let is_met = along.is_met(stop);
            let margin = TOUCHED * size;
            let own = maxima.into_iter().filter(|one| {
                let is_contact = !one.is_between && is_met && one.value.abs() <= margin;
                !is_contact
            });
            let own: Vec<Maximum> = own.collect();
            if own.iter().any(|one| one.value.abs() <= margin) {
                touched = touched.or(Some(stop));
            }
            let mut least = largest(own.into_iter(), SAME_EXTREME * size);
            least.value = -least.value;
            if is_met && least.value > -margin {
                least = Extreme {
                    value: 0.0,
                    places: Vec::new(),
                };
            }
            gaps.push(least);
        }
        Ok(Self {
            gaps,
            displacements,
            touched,
        })
    }
}

impl Along<'_> {
    /// The gap of a stop where it turns from closing to opening next to a place on a flight; none where it does not turn there.
    pub fn least_gap_near(&self, stop: usize, (flight, part): (usize, f64)) -> Result<Option<f64>> {
        let contacts = contacts(self.scene);
        let quantities = OrbitQuantities {
            along: self,
            contacts: &contacts,
        };
        let own = &self.flights[flight];
        let quantity = self.scene.n_dof() + stop;
        let at = |local: f64| Ok(quantities.at(flight, local, quantity)?.map(|x| -x));
        // From the place back to where it closes, and on to where it opens.
        let place = part * own.span;
        let end = |way: f64| -> Result<Option<(f64, f64)>> {
            let (mut local, mut reach) = (place, FIRST_BRACKET_PART * own.span);
            loop {
                let rate = at(local)?[1];
                if rate * way < 0.0 {
                    return Ok(Some((local, rate)));
                }
                if local <= 0.0 && way < 0.0 || local >= own.span && way > 0.0 {
                    return Ok(None);
                }
                local = (place + way * reach).clamp(0.0, own.span);
                reach *= 2.0;
            }
        };
        let (Some(low), Some(high)) = (end(-1.0)?, end(1.0)?) else {
            return Ok(None);
        };
        let (_, least) = turn(at, [low.0, high.0], [low.1, high.1])?;
        Ok(Some(-least))
    }

    /// Whether a stop is hit, or held.
    fn is_met(&self, stop: usize) -> bool {
        let mut flights = self.flights.iter();
        flights.any(|own| own.hits().contains(&stop) || own.touches(stop))
    }
}

/// The largest of some maxima, and where it is reached within a tolerance.
fn largest(maxima: impl Iterator<Item = Maximum>, tolerance: f64) -> Extreme {
    let maxima: Vec<Maximum> = maxima.collect();
    let most = |value: f64, one: &Maximum| value.max(one.value);
    let value = maxima.iter().fold(f64::NEG_INFINITY, most);
    let reached = maxima.iter().filter(|one| one.value >= value - tolerance);
    Extreme {
        value,
        places: reached.map(|one| one.place).collect(),
    }
}

/// The coordinates of an orbit and the gaps of its stops, anywhere on its flights.
struct OrbitQuantities<'a> {
    along: &'a Along<'a>,
    contacts: &'a [Contact],
}

impl OrbitQuantities<'_> {
    /// A coordinate, or after these the gap of a stop, and its rate so far along a flight.
    fn at(&self, flight: usize, local: f64, quantity: usize) -> Result<ValueAndRate> {
        let path = self.along.path;
        let at = path.point_along(flight, local);
        let (q, v) = path.state_in(at.arc, at.local);
        let time = self.along.flights[flight].start + local;
        self.of_state(time, (q.as_slice(), v.as_slice()), quantity)
    }

    fn of_state(
        &self,
        time: f64,
        (q, v): (&[f64], &[f64]),
        quantity: usize,
    ) -> Result<ValueAndRate> {
        let Some(stop) = quantity.checked_sub(q.len()) else {
            return Ok([q[quantity], v[quantity]]);
        };
        let w = self.along.scene.frequency().unwrap_or(0.0);
        let moment = || Moment::new(time, w * time + self.along.scene.phase(), w);
        let value = self.contacts[stop].along(moment, (q, v, v), 0.0)?;
        Ok([value.gap, value.speed])
    }

    /// All quantities at the points at which the motion is drawn; what is left of impacts that accumulate is no flight.
    fn sampled(&self) -> Result<Vec<FlightSamples>> {
        let (path, flights) = (self.along.path, self.along.flights);
        let count = self.along.scene.n_dof() + self.contacts.len();
        let mut sampled: Vec<FlightSamples> = Vec::with_capacity(flights.len());
        for point in path.points()? {
            let segments = &path.parts.segments;
            let flight = segments.partition_point(|own| own.first <= point.arc) - 1;
            let is_known = |flight: &&OrbitArc| flight.accumulation().is_none();
            let Some(own) = flights.get(flight).filter(is_known) else {
                continue;
            };
            if sampled.last().is_none_or(|last| last.flight != flight) {
                sampled.push(FlightSamples {
                    flight,
                    local: Vec::new(),
                    values: Vec::new(),
                });
            }
            let (q, v) = path.state_in(point.arc, point.local);
            let of = |quantity| self.of_state(point.time, (q.as_slice(), v.as_slice()), quantity);
            if let Some(last) = sampled.last_mut() {
                last.local
                    .push((point.time - own.start).clamp(0.0, own.span));
                last.values.push((0..count).map(of).collect::<Result<_>>()?);
            }
        }
        Ok(sampled)
    }

    /// The maxima of a quantity times a sign that may be the largest, those of a gap that may be a touch too, and the size of the quantity.
    fn maxima(
        &self,
        sampled: &[FlightSamples],
        quantity: usize,
        sign: f64,
    ) -> Result<(Vec<Maximum>, f64)> {
        let all = sampled.iter().flat_map(|own| &own.values);
        let values = all.map(|values| values[quantity][0]);
        let (most, size) = values.fold((f64::NEG_INFINITY, 0.0f64), |(most, size), x| {
            (most.max(sign * x), size.max(x.abs()))
        });
        let stop = quantity.checked_sub(self.along.scene.n_dof());
        let touch = TOUCHED * size;
        let bar = most - SAME_EXTREME * size;
        let bar = stop.map_or(bar, |_| bar.min(-touch));
        let mut maxima = Vec::new();
        for FlightSamples {
            flight,
            local,
            values,
        } in sampled
        {
            let own = &self.along.flights[*flight];
            let mut keep = |value: f64, local: f64, is_between: bool| {
                let place = PlaceOnFlight {
                    flight: *flight,
                    part: if own.span > 0.0 {
                        local / own.span
                    } else {
                        0.0
                    },
                    sign,
                };
                maxima.push(Maximum {
                    value,
                    place,
                    is_between,
                });
            };
            let signed = |k: usize| values[k][quantity].map(|x| sign * x);
            keep(signed(0)[0], 0.0, false);
            if stop.is_some_and(|stop| own.keeps_closed(stop)) {
                continue;
            }
            // A flight that begins on the stop may do so without speed; one into it goes deeper.
            let is_flight = stop.is_some_and(|stop| !own.touches(stop));
            let is_left = is_flight && signed(0)[0].abs() <= touch;
            for k in 1 + usize::from(is_left)..local.len() {
                let (from, to) = (signed(k - 1), signed(k));
                let step = local[k] - local[k - 1];
                let highest = (from[0] + from[1] * step).max(to[0] - to[1] * step);
                if from[1] > 0.0 && to[1] < 0.0 && highest >= bar {
                    let at = |local: f64| Ok(self.at(*flight, local, quantity)?.map(|x| sign * x));
                    let (place, value) = turn(at, [local[k - 1], local[k]], [from[1], to[1]])?;
                    keep(value, place, true);
                }
            }
        }
        Ok((maxima, size))
    }
}

/// Where a rate that is positive at the first of two times and negative at the second is zero, and the value there.
fn turn(
    at: impl Fn(f64) -> Result<ValueAndRate>,
    ends: [f64; 2],
    rates: [f64; 2],
) -> Result<(f64, f64)> {
    let mut there = f64::NAN;
    let search = FalsePosition::new(ends, rates);
    let place = search.zero(MOST_EXTREME_STEPS, |place| -> Result<Option<f64>> {
        let [value, rate] = at(place)?;
        there = value;
        Ok(Some(rate))
    })?;
    Ok((place.unwrap_or(f64::NAN), there))
}
