//! The products against triple loops, through the bindings that clarabel uses.
//!
//! All that a routine has no business with is NaN: the padding between columns, the other
//! triangle, an input times zero, an output that is to be overwritten. It must neither spread nor
//! change.

// Of `f64` to itself, in the cases for both precisions.
#![allow(clippy::useless_conversion, clippy::unnecessary_cast)]

use blas_src as _;

#[path = "../common/mod.rs"]
mod common;

mod single {
    use blas::{sgemm as gemm, sgemv as gemv, ssymv as symv, ssyr2k as syr2k, ssyrk as syrk};
    type T = f32;
    include!("cases.rs");
}

mod double {
    use blas::{dgemm as gemm, dgemv as gemv, dsymv as symv, dsyr2k as syr2k, dsyrk as syrk};
    type T = f64;
    include!("cases.rs");
}
