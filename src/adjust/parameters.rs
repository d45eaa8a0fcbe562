//! Blocks of parameters, their priors, and the columns they occupy.

use crate::math::dense::product;
use nalgebra::{DMatrix, Matrix3, Vector3};

use super::chart::Chart;
use super::error::AdjustError;

/// Unit of one tangent component; decides how it is worded and which limit its standard deviation meets.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Unit {
    /// Radian.
    Radian,
    /// Metre.
    Metre,
    /// Second.
    Second,
    /// Without a unit.
    One,
}

/// Name and unit of one tangent component of a block.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Component {
    /// Name, unique enough to be read in a report ("yaw").
    pub name: String,
    /// Unit of the tangent component.
    pub unit: Unit,
}

impl Component {
    /// A component of this name and unit.
    pub fn new(name: impl Into<String>, unit: Unit) -> Self {
        Component {
            name: name.into(),
            unit,
        }
    }
}

/// What is known of a block beforehand: an observation whose residual lives in the tangent ([`Chart::difference`]).
#[derive(Debug, Clone, PartialEq)]
pub struct Prior {
    /// Expected value, in the block's own representation.
    pub value: Vec<f64>,
    /// Covariance in the tangent at that value (component units squared), symmetric positive definite.
    pub covariance: DMatrix<f64>,
}

/// One block of parameters.
#[derive(Debug, Clone, PartialEq)]
pub struct Block {
    /// Name of the block ("sonar boresight").
    pub name: String,
    /// Names and units of the tangent components.
    pub components: Vec<Component>,
    /// The space it lives in.
    pub chart: Chart,
    /// Current value: n numbers, 9 of a rotation matrix by columns, or 3 of a unit normal.
    pub value: Vec<f64>,
    /// Prior knowledge, if any.
    pub prior: Option<Prior>,
    /// Per tangent component: true keeps it at its value.
    pub held: Vec<bool>,
    /// Whether it is what the adjustment is made for: figures of single conditions are given for the blocks sought.
    pub sought: bool,
}

impl Block {
    /// Plain numbers with their names and units, free and without prior.
    pub fn euclidean(name: impl Into<String>, components: Vec<Component>, value: &[f64]) -> Self {
        Self::new(
            name,
            components,
            Chart::Euclidean(value.len()),
            value.to_vec(),
        )
    }

    /// A rotation, free and without prior; components name the rotation vector's axes (rad).
    pub fn rotation(name: impl Into<String>, axes: [&str; 3], value: &Matrix3<f64>) -> Self {
        let components = axes.map(|axis| Component::new(axis, Unit::Radian)).to_vec();
        Self::new(name, components, Chart::Rotation, value.as_slice().to_vec())
    }

    /// A unit normal, free and without prior; its components are called `NAME tilt 1` and `NAME tilt 2`.
    pub fn unit_normal(name: impl Into<String>, value: &Vector3<f64>) -> Self {
        let name = name.into();
        let components = [1, 2]
            .map(|i| Component::new(format!("{name} tilt {i}"), Unit::Radian))
            .to_vec();
        Self::new(
            name,
            components,
            Chart::UnitNormal,
            value.as_slice().to_vec(),
        )
    }

    fn new(
        name: impl Into<String>,
        components: Vec<Component>,
        chart: Chart,
        value: Vec<f64>,
    ) -> Self {
        let held = vec![false; chart.tangent_size()];
        Block {
            name: name.into(),
            components,
            chart,
            value,
            prior: None,
            held,
            sought: false,
        }
    }

    /// The same block with a prior.
    #[must_use]
    pub fn with_prior(mut self, value: Vec<f64>, covariance: DMatrix<f64>) -> Self {
        self.prior = Some(Prior { value, covariance });
        self
    }

    /// The same block, held at its value.
    #[must_use]
    pub fn held(mut self) -> Self {
        self.held.fill(true);
        self
    }

    /// The same block, marked as one that the adjustment is made for.
    #[must_use]
    pub fn sought(mut self) -> Self {
        self.sought = true;
        self
    }

    fn check(&self) -> Result<(), AdjustError> {
        let (values, tangents) = (self.chart.value_size(), self.chart.tangent_size());
        self.expect("value", self.value.len(), values)?;
        self.expect("component list", self.components.len(), tangents)?;
        self.expect("held list", self.held.len(), tangents)?;
        if let Some(prior) = &self.prior {
            self.expect("prior value", prior.value.len(), values)?;
            self.expect("prior covariance", prior.covariance.nrows(), tangents)?;
            self.expect("prior covariance", prior.covariance.ncols(), tangents)?;
            self.root_information(prior)?;
        }
        Ok(())
    }

    fn expect(&self, what: &'static str, found: usize, expected: usize) -> Result<(), AdjustError> {
        if found == expected {
            return Ok(());
        }
        Err(AdjustError::BadBlock {
            block: self.name.clone(),
            what,
            found,
            expected,
        })
    }

    /// Inverse Cholesky factor of the prior's covariance: whitens its residual.
    fn root_information(&self, prior: &Prior) -> Result<DMatrix<f64>, AdjustError> {
        let bad = || AdjustError::BadPrior {
            block: self.name.clone(),
        };
        let factor = prior.covariance.clone().cholesky().ok_or_else(bad)?;
        factor.l().try_inverse().ok_or_else(bad)
    }
}

/// Handle of a block in a [`ParameterSet`].
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub struct BlockId(usize);

/// Every block of a problem in the order of its columns.
///
/// Columns count the tangent components of *all* blocks, held ones included; the engine drops the held ones itself.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct ParameterSet {
    blocks: Vec<Block>,
    offsets: Vec<usize>,
    columns: usize,
}

impl ParameterSet {
    /// An empty set.
    pub fn new() -> Self {
        Self::default()
    }

    /// Appends a block.
    ///
    /// # Errors
    /// [`AdjustError::BadBlock`] or [`AdjustError::BadPrior`] when its parts do not fit its chart.
    pub fn push(&mut self, block: Block) -> Result<BlockId, AdjustError> {
        block.check()?;
        self.offsets.push(self.columns);
        self.columns += block.chart.tangent_size();
        self.blocks.push(block);
        Ok(BlockId(self.blocks.len() - 1))
    }

    /// All blocks.
    pub fn blocks(&self) -> &[Block] {
        &self.blocks
    }

    /// Handles of all blocks, in order.
    pub(super) fn ids(&self) -> impl Iterator<Item = BlockId> + use<> {
        (0..self.blocks.len()).map(BlockId)
    }

    /// One block.
    pub fn block(&self, id: BlockId) -> &Block {
        &self.blocks[id.0]
    }

    /// One block, to change its value, prior or flags (not its sizes).
    pub fn block_mut(&mut self, id: BlockId) -> &mut Block {
        &mut self.blocks[id.0]
    }

    /// The block of this name.
    pub fn find(&self, name: &str) -> Option<BlockId> {
        self.blocks
            .iter()
            .position(|block| block.name == name)
            .map(BlockId)
    }

    /// First column of a block.
    pub fn offset(&self, id: BlockId) -> usize {
        self.offsets[id.0]
    }

    /// Columns of all blocks, held ones included.
    pub fn columns(&self) -> usize {
        self.columns
    }

    /// Value of a rotation block.
    pub fn rotation(&self, id: BlockId) -> Matrix3<f64> {
        Matrix3::from_column_slice(&self.blocks[id.0].value)
    }

    /// Value of a unit normal block.
    pub fn normal(&self, id: BlockId) -> Vector3<f64> {
        Vector3::from_column_slice(&self.blocks[id.0].value)
    }

    /// Value of a block as stored.
    pub fn euclidean(&self, id: BlockId) -> &[f64] {
        &self.blocks[id.0].value
    }

    /// Columns that are estimated, in order.
    pub fn free_columns(&self) -> Vec<usize> {
        let held = self.blocks.iter().flat_map(|block| &block.held);
        held.enumerate()
            .filter(|(_, held)| !**held)
            .map(|(column, _)| column)
            .collect()
    }

    /// Columns of the blocks sought, in order; held ones too.
    pub fn sought_columns(&self) -> Vec<usize> {
        let blocks = self.blocks.iter().zip(&self.offsets);
        blocks
            .filter(|(block, _)| block.sought)
            .flat_map(|(block, offset)| *offset..offset + block.components.len())
            .collect()
    }

    /// Name and unit of every column sought.
    pub fn sought(&self) -> impl Iterator<Item = &Component> {
        let blocks = self.blocks.iter().filter(|block| block.sought);
        blocks.flat_map(|block| &block.components)
    }

    /// Name and unit of every column.
    pub fn components(&self) -> impl Iterator<Item = &Component> {
        self.blocks.iter().flat_map(|block| &block.components)
    }

    /// The set moved by a tangent step over all columns.
    #[must_use]
    pub fn retracted(&self, step: &[f64]) -> Self {
        let mut moved = self.clone();
        for (block, offset) in moved.blocks.iter_mut().zip(&self.offsets) {
            let size = block.chart.tangent_size();
            block
                .chart
                .retract(&mut block.value, &step[*offset..offset + size]);
        }
        moved
    }

    /// The values of all blocks, one behind the other.
    #[must_use]
    pub fn values(&self) -> Vec<f64> {
        let values = self.blocks.iter().flat_map(|block| &block.value);
        values.copied().collect()
    }

    /// The set with other values, as [`Self::values`] gives them; `None` where they are not as many.
    #[must_use]
    pub fn with_values(&self, values: &[f64]) -> Option<Self> {
        let (mut set, mut rest) = (self.clone(), values);
        for block in &mut set.blocks {
            let (own, behind) = rest.split_at_checked(block.value.len())?;
            block.value.copy_from_slice(own);
            rest = behind;
        }
        rest.is_empty().then_some(set)
    }

    /// Number of scalar priors.
    pub fn prior_count(&self) -> usize {
        self.blocks
            .iter()
            .filter(|block| block.prior.is_some())
            .map(|block| block.chart.tangent_size())
            .sum()
    }

    /// Information of all priors over all columns.
    ///
    /// # Errors
    /// As [`Self::prior_rows`].
    pub fn prior_information(&self) -> Result<DMatrix<f64>, AdjustError> {
        let mut information = DMatrix::zeros(self.columns, self.columns);
        for row in self.prior_rows()? {
            for (i, a) in row.derivatives.iter().enumerate() {
                for (j, b) in row.derivatives.iter().enumerate() {
                    information[(row.column + i, row.column + j)] += a * b;
                }
            }
        }
        Ok(information)
    }

    /// Whitened rows of all priors: `(first column, derivatives of that block, residual)`, residuals in sigmas.
    ///
    /// # Errors
    /// [`AdjustError::BadPrior`] when a covariance was made unusable after the block was pushed.
    pub fn prior_rows(&self) -> Result<Vec<PriorRow>, AdjustError> {
        let mut rows = Vec::new();
        for (block, offset) in self.blocks.iter().zip(&self.offsets) {
            if let Some(prior) = &block.prior {
                rows.extend(whitened(block, prior, *offset)?);
            }
        }
        Ok(rows)
    }
}

/// One whitened row of a prior.
#[derive(Debug, Clone, PartialEq)]
pub struct PriorRow {
    /// First column of its block.
    pub column: usize,
    /// Derivatives by the block's tangent components, in sigmas per unit.
    pub derivatives: Vec<f64>,
    /// Residual in sigmas.
    pub residual: f64,
}

fn whitened(block: &Block, prior: &Prior, column: usize) -> Result<Vec<PriorRow>, AdjustError> {
    let n = block.chart.tangent_size();
    let root = block.root_information(prior)?;
    let jacobian = block.chart.difference_jacobian(&block.value, &prior.value);
    let jacobian = product(&root, &DMatrix::from_row_slice(n, n, &jacobian));
    let residual =
        root * DMatrix::from_vec(n, 1, block.chart.difference(&block.value, &prior.value));
    let row = |i| PriorRow {
        column,
        derivatives: jacobian.row(i).iter().copied().collect(),
        residual: residual[i],
    };
    Ok((0..n).map(row).collect())
}
