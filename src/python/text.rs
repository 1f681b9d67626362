//! Values and numbers as messages and `repr` show them.

use nalgebra::{Complex, DVector};
use pyo3::prelude::*;

/// Entries of a vector that a line has room for. [exact]
const SHOWN_ENTRIES: usize = 6;

/// Characters of a value that a message has room for. [exact]
const SHOWN_CHARACTERS: usize = 160;

/// A value as Python writes it, the middle of long ones left out; one of many lines by its type.
pub(crate) fn shown(value: &Bound<'_, PyAny>) -> String {
    let text = value
        .repr()
        .map_or_else(|_| "this value".to_owned(), |r| r.to_string());
    if text.contains('\n') {
        let of = value.get_type().name();
        return of.map_or_else(|_| "this value".to_owned(), |of| format!("of type {of}"));
    }
    let count = text.chars().count();
    if count <= SHOWN_CHARACTERS {
        return text;
    }
    let begin: String = text.chars().take(SHOWN_CHARACTERS / 2).collect();
    let end: String = text.chars().skip(count - SHOWN_CHARACTERS / 4).collect();
    format!("{begin} ... {end}")
}

/// A number to six decimals; what rounds to zero has no sign.
pub(crate) fn fixed(x: f64) -> String {
    let text = format!("{x:.6}");
    match text.strip_prefix('-') {
        Some(zero) if !zero.contains(|c: char| ('1'..='9').contains(&c) || c.is_alphabetic()) => {
            zero.to_owned()
        }
        _ => text,
    }
}

/// The first entries of a vector.
pub(crate) fn list(v: &DVector<f64>) -> String {
    let shown: Vec<String> = v.iter().take(SHOWN_ENTRIES).map(|&x| fixed(x)).collect();
    let more = if v.len() > SHOWN_ENTRIES { ", ..." } else { "" };
    format!("[{}{more}]", shown.join(", "))
}

/// A complex number to six decimals.
pub(crate) fn fixed_complex(z: Complex<f64>) -> String {
    let im = fixed(z.im);
    let sign = if im.starts_with('-') { "" } else { "+" };
    format!("{}{sign}{im}i", fixed(z.re))
}

/// A value as a notebook shows it, by a function of `vibroimpact.results.html`.
pub(crate) fn html(value: &Bound<'_, PyAny>, form: &str) -> PyResult<String> {
    let forms = value.py().import("vibroimpact.results.html")?;
    forms.call_method1(form, (value,))?.extract()
}
