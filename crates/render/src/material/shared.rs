//! Tables that several materials have in common.

use std::sync::Arc;

use sahl_scene::{Diagnostics, MeasuredBrdf, Span};

use crate::bsdf::MeasuredTables;

/// Tables made so far for the materials of a scene.
#[derive(Debug, Default)]
pub(crate) struct SharedTables {
    measured: Vec<(Arc<MeasuredBrdf>, Arc<MeasuredTables>)>,
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
}
