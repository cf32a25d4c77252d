//! The BLAS and LAPACK symbols that clarabel's semidefinite cones call, in Rust alone.
//!
//! clarabel multiplies and factors its dense matrices through 22 Fortran symbols. The packages
//! that usually provide them compile or download a large foreign library; this one takes their
//! place by `[patch.crates-io]`. It is the binary interface: the products are matrixmultiply's,
//! the factorisations nalgebra's; only the singular value decomposition is written here.
//!
//! # Conventions
//! - Arguments, storage (column-major, leading dimensions, named triangles) and INFO codes are
//!   those of the reference BLAS and LAPACK. Fortran's hidden string lengths may be passed; they
//!   are not read.
//! - BLAS routines have no INFO: given an illegal argument they leave the output as it is.
//! - An output scaled by `beta = 0` is written and never read; an input scaled by `alpha = 0` is
//!   not read.
//! - The factorisations answer a NaN or an infinity with INFO > 0.
//! - Workspaces are accepted and not used; the size a query reports is 1.
//! - Left out, and refused by the INFO of that argument: RANGE other than `A` in `syevr`, jobs
//!   other than `N` and `S` in `gesdd` and `gesvd`.
//!
//! With the feature `openblas-system` this package defines no symbol and links Debian's
//! `libopenblas-dev`.

#[cfg(not(feature = "openblas-system"))]
mod abi;
#[cfg(not(feature = "openblas-system"))]
mod blas;
#[cfg(not(feature = "openblas-system"))]
mod lapack;
#[cfg(not(feature = "openblas-system"))]
mod storage;
#[cfg(not(feature = "openblas-system"))]
mod svd;
