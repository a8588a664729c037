//! sahl
