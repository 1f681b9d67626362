//! A referee for branches: random scenes whose orbits, special points and curves are compared with mechanics written down anew,
//! chains from the places of their bobs and linear systems from Newton's law, followed by extrapolated steps that are much
//! shorter than the motion.

mod body;
mod condition;
mod counts;
mod curves;
mod draw;
mod families;
mod flights;
mod followed;
mod integrated;
mod library;
mod look;
mod map;
mod plant;
mod rules;
mod script;
mod stays;
mod stepper;
mod tally;
mod tori;

use crate::random::{Cases, Random};
use tally::Tally;

/// Looks at each case, and says which of them disagree.
fn compared(
    name: &str,
    cases: Cases,
    check: impl Fn(&mut Random, &mut Tally) -> Result<(), String>,
) -> Tally {
    let mut tally = Tally::default();
    let mut failed = Vec::new();
    for (number, mut random) in cases.each() {
        if let Err(wrong) = check(&mut random, &mut tally) {
            println!("{name} {number} of seed {}: {wrong}", cases.seed);
            failed.push(number);
        }
    }
    if !cases.is_one() {
        crate::soak::note(name, cases.seed, cases.numbers().len(), failed.len());
    }
    tally.print(name);
    assert!(
        failed.is_empty(),
        "the library and the referee disagree: {failed:?}"
    );
    tally
}

/// Whether so many were compared in a hundred cases, or more.
fn check(cases: Cases, tally: &Tally, wanted: &[(&str, usize)]) {
    for (what, in_a_hundred) in wanted {
        let seen = tally.number(what);
        assert!(cases.have(seen, *in_a_hundred), "{seen} {what}");
    }
}

#[test]
fn branches_of_pendulums_are_what_the_referee_says() {
    let cases = Cases::new(12, 30);
    let tally = compared("branches of pendulums", cases, integrated::check);
    let wanted = [
        ("orbits", 100),
        ("multipliers", 80),
        ("kept rules", 60),
        ("broken rules", 10),
        ("pairs of points", 800),
        ("multipliers that crossed", 20),
    ];
    check(cases, &tally, &wanted);
}

#[test]
fn branches_of_linear_systems_are_what_the_referee_says() {
    let cases = Cases::new(7, 40);
    let tally = compared("branches of linear systems", cases, followed::check_linear);
    let wanted = [
        ("branches", 80),
        ("points", 1500),
        ("pairs of points", 1000),
        ("multipliers that crossed", 20),
    ];
    check(cases, &tally, &wanted);
}

#[test]
fn branches_beside_springs_close_as_the_referee_says() {
    let cases = Cases::new(8, 5);
    let tally = compared("branches beside springs", cases, followed::check_sprung);
    check(cases, &tally, &[("branches", 50), ("points", 800)]);
}

#[test]
fn stays_that_are_cut_push_to_their_ends() {
    let cases = Cases::new(9, 150);
    let tally = compared("stays", cases, stays::check);
    check(cases, &tally, &[("cut stays", 50), ("stays", 10)]);
}

#[test]
fn tori_turn_as_the_referee_says() {
    let cases = Cases::new(2, 120);
    let tally = compared("tori", cases, tori::check);
    check(cases, &tally, &[("tori", 5), ("rotation numbers", 5)]);
}

#[test]
fn families_are_what_the_referee_says() {
    let cases = Cases::new(3, 30);
    let tally = compared("families", cases, families::check);
    let wanted = [
        ("families", 30),
        ("cycles", 8),
        ("actions", 40),
        ("orbits", 100),
    ];
    check(cases, &tally, &wanted);
}

#[test]
fn curves_have_what_the_referee_says() {
    let cases = Cases::new(4, 40);
    let tally = compared("curves", cases, curves::check);
    let wanted = [
        ("curves", 40),
        ("verdicts", 60),
        ("fold", 10),
        ("period_doubling", 15),
        ("graze", 20),
    ];
    check(cases, &tally, &wanted);
}
