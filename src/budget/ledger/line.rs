//! A trial as a line of a ledger.

use nalgebra::Matrix6;

use crate::budget::trial::{Error6, JointTrial, Reason, Trial};

const SIX: [&str; 6] = ["pitch_rad", "roll_rad", "yaw_rad", "lx_m", "ly_m", "lz_m"];

/// Names of the columns.
pub(super) fn columns() -> Vec<String> {
    let errors = |path: &'static str| SIX.map(move |p| format!("{path}_error_{p}"));
    let short = ["pitch", "roll", "yaw", "lx", "ly", "lz"];
    let pairs = (0..6).flat_map(|i| (0..=i).map(move |j| (i, j)));
    let mut all = vec!["seed".to_owned()];
    all.extend(errors("joint"));
    all.extend(pairs.map(|(i, j)| format!("joint_covariance_{}_{}", short[i], short[j])));
    all.push("joint_variance_factor".to_owned());
    all.extend(["joint_refusal", "joint_reason"].map(str::to_owned));
    for path in ["sequential", "projected"] {
        all.extend(errors(path));
        all.extend([format!("{path}_refusal"), format!("{path}_reason")]);
    }
    all
}

/// A record with its line end.
pub(super) fn to_line(trial: &Trial) -> Vec<u8> {
    let mut fields = vec![trial.seed.to_string()];
    match &trial.joint {
        Ok(joint) => {
            fields.extend(joint.error.map(exact));
            fields.extend(lower().map(|(i, j)| exact(joint.covariance[(i, j)])));
            fields.push(joint.variance_factor.map_or_else(String::new, exact));
            fields.extend([String::new(), String::new()]);
        }
        Err(reason) => refused(&mut fields, 28, reason),
    }
    for path in [&trial.sequential, &trial.projected] {
        match path {
            Ok(error) => {
                fields.extend(error.map(exact));
                fields.extend([String::new(), String::new()]);
            }
            Err(reason) => refused(&mut fields, 6, reason),
        }
    }
    let mut line = csv::WriterBuilder::new().from_writer(vec![]);
    // writing to memory does not fail
    let _ = line.write_record(&fields);
    line.into_inner().unwrap_or_default()
}

fn refused(fields: &mut Vec<String>, empty: usize, reason: &Reason) {
    fields.extend(std::iter::repeat_n(String::new(), empty));
    fields.extend([reason.code.clone(), reason.text.clone()]);
}

/// The shortest digits that bring the number back.
fn exact(value: f64) -> String {
    format!("{value:e}")
}

fn lower() -> impl Iterator<Item = (usize, usize)> {
    (0..6).flat_map(|i| (0..=i).map(move |j| (i, j)))
}

pub(super) fn from_line(line: &[u8]) -> Option<Trial> {
    let mut reader = csv::ReaderBuilder::new()
        .has_headers(false)
        .from_reader(line);
    let record = reader.records().next()?.ok()?;
    if record.len() != columns().len() {
        return None;
    }
    let fields: Vec<&str> = record.iter().collect();
    Some(Trial {
        seed: fields[0].parse().ok()?,
        joint: joint(&fields[1..31])?,
        sequential: error(&fields[31..39])?,
        projected: error(&fields[39..47])?,
    })
}

fn reason(fields: &[&str]) -> Option<Reason> {
    (!fields[0].is_empty()).then(|| Reason {
        code: fields[0].to_owned(),
        text: fields[1].to_owned(),
    })
}

fn numbers<const N: usize>(fields: &[&str]) -> Option<[f64; N]> {
    let mut all = [0.0; N];
    for (number, field) in all.iter_mut().zip(fields) {
        *number = field.parse().ok()?;
    }
    Some(all)
}

fn joint(fields: &[&str]) -> Option<Result<JointTrial, Reason>> {
    if let Some(reason) = reason(&fields[28..]) {
        return Some(Err(reason));
    }
    let values: [f64; 21] = numbers(&fields[6..27])?;
    let mut covariance = Matrix6::zeros();
    for ((i, j), value) in lower().zip(values) {
        (covariance[(i, j)], covariance[(j, i)]) = (value, value);
    }
    let factor = fields[27];
    let variance_factor = if factor.is_empty() {
        None
    } else {
        Some(factor.parse().ok()?)
    };
    Some(Ok(JointTrial {
        error: numbers(fields)?,
        covariance,
        variance_factor,
        optional: vec![],
    }))
}

fn error(fields: &[&str]) -> Option<Result<Error6, Reason>> {
    match reason(&fields[6..]) {
        Some(reason) => Some(Err(reason)),
        None => numbers(fields).map(Ok),
    }
}
