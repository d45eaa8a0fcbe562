//! The unknowns of the joint path with their starts and priors.

use nalgebra::{DMatrix, Vector3};

use super::super::conditions::{FacePlane, MountingBlocks};
use super::super::config::{JointConfig, Planes};
use super::super::planes::GroupPlanes;
use super::super::scene::Scene;
use super::{Blocks, JointStart, SIX};
use crate::adjust::{AdjustError, Block, BlockId, Component, ParameterSet, Unit};
use crate::geometry::rotation;
use crate::observe::{Extra, Mounting};

/// Every block of the adjustment, at its start.
pub(super) fn parameters(
    scene: &Scene,
    start: &JointStart,
    config: &JointConfig,
) -> Result<(ParameterSet, Blocks), AdjustError> {
    let mut x = ParameterSet::new();
    let mounting = push_mounting(&mut x, scene, &start.mounting, config)?;
    let free = config.planes == Planes::Adjusted;
    let scanner = match scene.campaign.scanner_sigma {
        Some(sigma) if free && scene.laser_uses_trajectory() => {
            Some(push_scanner(&mut x, scene, &sigma)?)
        }
        _ => None,
    };
    let scalar = |x: &mut ParameterSet, name: &str, unit| {
        let block = Block::euclidean(name, vec![Component::new(name, unit)], &[0.0]);
        x.push(block.sought())
    };
    let latency = config
        .latency
        .then(|| scalar(&mut x, "latency", Unit::Second))
        .transpose()?;
    let range_scale = config
        .range_scale
        .then(|| scalar(&mut x, "range_scale", Unit::One))
        .transpose()?;
    let extras = scene.extras.iter().map(|extra| push_extra(&mut x, extra));
    let extras = extras.collect::<Result<_, _>>()?;
    let faces = push_planes(&mut x, scene, start.planes, free)?;
    Ok((
        x,
        Blocks {
            mounting,
            scanner,
            latency,
            range_scale,
            extras,
            faces,
        },
    ))
}

fn push_mounting(
    x: &mut ParameterSet,
    scene: &Scene,
    rough: &Mounting,
    config: &JointConfig,
) -> Result<MountingBlocks, AdjustError> {
    let nominal = &scene.campaign.sonar;
    let held: Vec<bool> = SIX
        .iter()
        .map(|name| config.hold.iter().any(|h| h == name))
        .collect();
    let mut delta = rough.correction_from(nominal);
    let mut arm = rough.lever_arm_m;
    for i in 0..3 {
        if held[i] {
            delta[i] = 0.0;
        }
        if held[i + 3] {
            arm[i] = nominal.lever_arm_m[i];
        }
    }
    let mut turn = Block::rotation(
        "mounting angles",
        ["pitch", "roll", "yaw"],
        &(rotation::exp(&delta) * nominal.rotation),
    );
    turn.held.copy_from_slice(&held[..3]);
    let metres = ["lx", "ly", "lz"]
        .map(|name| Component::new(name, Unit::Metre))
        .to_vec();
    let mut lever = Block::euclidean("lever arm", metres, arm.as_slice());
    lever.held.copy_from_slice(&held[3..]);
    let p = &config.prior;
    let rad = |deg: Option<f64>| deg.map(f64::to_radians);
    if let Some(covariance) = prior_covariance(
        [
            rad(p.pitch_sigma_deg),
            rad(p.roll_sigma_deg),
            rad(p.yaw_sigma_deg),
        ],
        10.0,
    ) {
        turn = turn.with_prior(nominal.rotation.as_slice().to_vec(), covariance);
    }
    if let Some(covariance) = prior_covariance([p.lx_sigma_m, p.ly_sigma_m, p.lz_sigma_m], 1e3) {
        lever = lever.with_prior(nominal.lever_arm_m.as_slice().to_vec(), covariance);
    }
    Ok(MountingBlocks {
        rotation: x.push(turn.sought())?,
        lever_arm: x.push(lever.sought())?,
    })
}

/// Diagonal covariance of the given sigmas, `vague` for those not given; `None` when none is.
fn prior_covariance(sigmas: [Option<f64>; 3], vague: f64) -> Option<DMatrix<f64>> {
    if sigmas.iter().all(Option::is_none) {
        return None;
    }
    let diagonal = sigmas.map(|s| s.unwrap_or(vague).powi(2));
    Some(DMatrix::from_diagonal(&nalgebra::DVector::from_row_slice(
        &diagonal,
    )))
}

fn push_scanner(
    x: &mut ParameterSet,
    scene: &Scene,
    sigma: &crate::observe::MountingSigma,
) -> Result<MountingBlocks, AdjustError> {
    let scanner = &scene.campaign.scanner;
    let square = |v: &Vector3<f64>| {
        DMatrix::from_diagonal(&nalgebra::DVector::from_iterator(
            3,
            v.iter().map(|s| s.max(1e-9).powi(2)),
        ))
    };
    let turn = Block::rotation(
        "scanner angles",
        ["scanner pitch", "scanner roll", "scanner yaw"],
        &scanner.rotation,
    )
    .with_prior(
        scanner.rotation.as_slice().to_vec(),
        square(&sigma.rotation_rad),
    );
    let metres = ["scanner lx", "scanner ly", "scanner lz"]
        .map(|n| Component::new(n, Unit::Metre))
        .to_vec();
    let lever = Block::euclidean("scanner lever arm", metres, scanner.lever_arm_m.as_slice())
        .with_prior(
            scanner.lever_arm_m.as_slice().to_vec(),
            square(&sigma.lever_arm_m),
        );
    Ok(MountingBlocks {
        rotation: x.push(turn)?,
        lever_arm: x.push(lever)?,
    })
}

/// An unknown of the caller's own, which begins at zero.
fn push_extra(x: &mut ParameterSet, extra: &Extra) -> Result<BlockId, AdjustError> {
    let component = Component::new(extra.name.clone(), Unit::One);
    let block = Block::euclidean(extra.name.clone(), vec![component], &[0.0]);
    x.push(match extra.prior_sigma {
        Some(sigma) => block.with_prior(vec![0.0], DMatrix::from_element(1, 1, sigma.powi(2))),
        None => block,
    })
}

/// A unit normal and a distance per group that the scanner saw, and an observed offset per face with a tolerance.
fn push_planes(
    x: &mut ParameterSet,
    scene: &Scene,
    planes: &GroupPlanes,
    free: bool,
) -> Result<Vec<Option<FacePlane>>, AdjustError> {
    let target = scene.target;
    let mut groups: Vec<Option<(BlockId, BlockId)>> = vec![None; target.groups.len()];
    for (group, plane) in planes.iter().enumerate() {
        let Some(plane) = plane else { continue };
        let name = &target.groups[group].name;
        let mut normal = Block::unit_normal(name.clone(), &plane.fit.plane.normal);
        let metre = vec![Component::new(format!("{name} distance"), Unit::Metre)];
        let mut distance = Block::euclidean(
            format!("{name} distance"),
            metre,
            &[plane.fit.plane.offset_m],
        );
        if !free {
            (normal, distance) = (normal.held(), distance.held());
        }
        groups[group] = Some((x.push(normal)?, x.push(distance)?));
    }
    let mut offsets: Vec<Option<BlockId>> = vec![None; target.offsets.len()];
    let mut faces = vec![];
    for face in &target.faces {
        let Some((normal, distance)) = groups[face.group] else {
            faces.push(None);
            continue;
        };
        let design = &target.offsets[face.offset];
        if design.sigma_m > 0.0 && offsets[face.offset].is_none() {
            let metre = vec![Component::new(
                format!("offset of {}", design.name),
                Unit::Metre,
            )];
            let variance = DMatrix::from_element(1, 1, design.sigma_m.powi(2));
            let block = Block::euclidean(
                format!("offset of {}", design.name),
                metre,
                &[design.value_m],
            )
            .with_prior(vec![design.value_m], variance);
            offsets[face.offset] = Some(x.push(block)?);
        }
        faces.push(Some(FacePlane {
            normal,
            distance,
            offset: offsets[face.offset],
            design_m: design.value_m,
        }));
    }
    Ok(faces)
}
