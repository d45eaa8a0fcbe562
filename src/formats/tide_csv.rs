//! Tide CSV: `time_s,height_m`, the height of the water over a datum, up positive.

use std::io::{Read, Write};
use std::path::Path;

use super::error::{FaultKind, FormatError, Place, open};
use super::rows::Rows;
use super::table::{Limits, Table};
use super::whole::write_whole;
use crate::observe::TideCurve;

// LAYOUT

const COLUMNS: [&str; 2] = ["time_s", "height_m"];
const HEIGHT: Limits = Limits {
    min: -20.0,
    max: 20.0,
    expected: "a height of the water from -20 to 20 m (is it in feet or centimetres?)",
};
/// Fastest tide that is taken for one, metres an hour: those of Fundy and the Severn, 16 m from low to high water, run at 4.
const FASTEST_M_H: f64 = 6.0;

// READ

/// Reads a tide curve.
///
/// # Errors
/// [`FormatError`]: unreadable, empty, a column missing, a value impossible, times that do not strictly ascend, a tide too fast to be one.
pub fn read(path: &Path) -> Result<TideCurve, FormatError> {
    let (file, size) = open(path)?;
    read_from(path, file, size)
}

/// Reads a tide curve of `size` bytes from `source`; `file` names it in messages.
///
/// # Errors
/// As [`read`].
pub fn read_from(file: &Path, source: impl Read, size: u64) -> Result<TideCurve, FormatError> {
    let mut table = Table::open(file, source, size, &COLUMNS, &[])?;
    let (mut curve, mut lines) = (TideCurve::default(), vec![]);
    table.each(None, |table| {
        let height_m = table.number(1, &HEIGHT)?;
        let time_s = table.time(0, curve.time_s.last().copied(), true)?;
        curve.time_s.push(time_s);
        curve.height_m.push(height_m);
        lines.push(table.line());
        Ok(())
    })?;
    slow_enough(file, &curve, &lines)?;
    Ok(curve)
}

/// Refuses what rises or falls faster than any tide.
fn slow_enough(file: &Path, curve: &TideCurve, lines: &[u64]) -> Result<(), FormatError> {
    let Some((row, m_s)) = curve.steepest() else {
        return Ok(());
    };
    let m_h = m_s * 3600.0;
    if m_h <= FASTEST_M_H {
        return Ok(());
    }
    let place = Place::Line {
        line: lines[row],
        column: COLUMNS[1].to_owned(),
    };
    let found = format!(
        "{} m {} s after {} m: {m_h:.1} m an hour",
        curve.height_m[row],
        curve.time_s[row] - curve.time_s[row - 1],
        curve.height_m[row - 1]
    );
    let expected = format!(
        "a tide, none of which runs faster than {FASTEST_M_H} m an hour (in feet? times not in seconds?)"
    );
    Err(FormatError::new(
        FaultKind::WrongUnit,
        file,
        place,
        found,
        expected,
    ))
}

// WRITE

/// Writes a tide curve, every digit.
///
/// # Errors
/// [`FormatError`] of kind `Unwritable`.
pub fn write(path: &Path, curve: &TideCurve) -> Result<(), FormatError> {
    write_whole(path, |w| write_to(w, curve))
}

/// Writes a tide curve into `out`, see [`write()`].
///
/// # Errors
/// Those of `out`.
pub fn write_to(out: &mut impl Write, curve: &TideCurve) -> std::io::Result<()> {
    writeln!(out, "{}", COLUMNS.join(","))?;
    for (time_s, height_m) in curve.time_s.iter().zip(&curve.height_m) {
        writeln!(out, "{time_s},{height_m}")?;
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;

    fn of(text: &str) -> Result<TideCurve, FormatError> {
        read_from(Path::new("tide.csv"), text.as_bytes(), text.len() as u64)
    }

    #[test]
    fn a_curve_returns_and_its_times_may_be_dates() {
        let curve = TideCurve {
            time_s: vec![0.0, 600.5, 1200.0],
            height_m: vec![-0.25, 0.1, 0.333],
        };
        let mut bytes = vec![];
        write_to(&mut bytes, &curve).expect("written");
        let text = String::from_utf8(bytes).expect("text");
        assert_eq!(of(&text), Ok(curve));
        let dated = "time_s;height_m\n2026-06-12T08:30:00Z;1,5\n2026-06-12 10:40:00+02:00;1.75\n";
        let curve = of(dated).expect("a curve");
        assert_eq!(curve.time_s, [1_781_253_000.0, 1_781_253_600.0]);
        assert_eq!(curve.height_m, [1.5, 1.75]);
    }

    #[test]
    fn what_is_no_tide_is_refused_by_its_line() {
        let said = |text: &str| of(text).expect_err(text).to_string();
        for (text, words) in [
            ("time_s,height_ft\n0,1\n", "line 1, column height_m"),
            (
                "time_s,height_m\n0,1\n600,31.2\n",
                "line 3, column height_m: found \"31.2\", expected a height of the water from -20 to 20 m (is it in feet",
            ),
            (
                "time_s,height_m\n0,1\n600,1\n300,1\n",
                "line 4, column time_s: found 300 after 600, expected strictly ascending times",
            ),
            ("time_s,height_m\n0,0.5\n0,0.5\n", "0 a second time"),
            (
                "time_s,height_m\n0,0.5\n600,1.6\n",
                "line 3, column height_m: found 1.6 m 600 s after 0.5 m: 6.6 m an hour",
            ),
            ("time_s,height_m\n", "at least one row"),
        ] {
            let found = said(text);
            assert!(found.contains(words), "{words}: {found}");
        }
    }
}
