//! Tables that several materials have in common.

use std::sync::Arc;

use sahl_scene::{Diagnostics, MeasuredBrdf, Span};

use crate::bsdf::MeasuredTables;
use crate::subsurface::DiffusionTable;

/// Tables made so far for the materials of a scene.
#[derive(Debug, Default)]
pub(crate) struct SharedTables {
    measured: Vec<(Arc<MeasuredBrdf>, Arc<MeasuredTables>)>,
    /// By mean cosine and index of refraction.
    diffusion: Vec<([f32; 2], Arc<DiffusionTable>)>,
}

impl SharedTables {
    /// The tables of a measurement; those of one that was seen before are used again.
    pub(super) fn measured(
        &mut self,
        brdf: &Arc<MeasuredBrdf>,
        span: Option<Span>,
        diagnostics: &mut Diagnostics,
    ) -> Arc<MeasuredTables> {
        if let Some((_, tables)) = self.measured.iter().find(|(known, _)| Arc::ptr_eq(known, brdf)) {
            return Arc::clone(tables);
        }
        let tables = Arc::new(MeasuredTables::new(brdf, span, diagnostics));
        self.measured.push((Arc::clone(brdf), Arc::clone(&tables)));
        tables
    }

    /// How light spreads in matter of the index `eta`, scattering with the mean cosine `g`.
    pub(super) fn diffusion(&mut self, g: f32, eta: f32) -> Arc<DiffusionTable> {
        if let Some((_, table)) = self.diffusion.iter().find(|(known, _)| *known == [g, eta]) {
            return Arc::clone(table);
        }
        let table = Arc::new(DiffusionTable::new(g, eta));
        self.diffusion.push(([g, eta], Arc::clone(&table)));
        table
    }
}
