//! The factorisations by what they promise (reconstruction, orthogonality, order, INFO), through
//! the bindings that clarabel uses.
//!
//! What a routine has no business with is NaN: the padding between columns and the other triangle.

// Of `f64` to itself, in the cases for both precisions.
#![allow(clippy::useless_conversion, clippy::unnecessary_cast)]

use blas_src as _;

#[path = "../common/mod.rs"]
mod common;

mod single {
    use lapack::{
        sgesdd as gesdd, sgesv as gesv, sgesvd as gesvd, spotrf as potrf, spotrs as potrs,
        ssyevr as syevr,
    };
    type T = f32;
    include!("cases.rs");
}

mod double {
    use lapack::{
        dgesdd as gesdd, dgesv as gesv, dgesvd as gesvd, dpotrf as potrf, dpotrs as potrs,
        dsyevr as syevr,
    };
    type T = f64;
    include!("cases.rs");
}
