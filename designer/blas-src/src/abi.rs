//! The exported symbols: each routine under its single and its double precision name.
//!
//! Every argument is a pointer, as in Fortran. An argument is `char`, `int` or `real` (a scalar,
//! read on entry), `input` or `output` (an array of reals), `indices` (an array of integers), or
//! `info` (one integer, written on return).

use std::ffi::{c_char, c_int};

use crate::{blas, lapack};

/// The foreign type of an argument.
macro_rules! foreign {
    (char $T:ty) => { &c_char };
    (int $T:ty) => { &c_int };
    (real $T:ty) => { &$T };
    (input $T:ty) => { *const $T };
    (output $T:ty) => { *mut $T };
    (indices $T:ty) => { *mut c_int };
    (info $T:ty) => { &mut c_int };
}

/// The argument as the generic routine takes it.
macro_rules! native {
    (char $value:ident) => {
        // `c_char` is signed on some platforms and unsigned on others.
        (*$value as u8).to_ascii_uppercase()
    };
    (int $value:ident) => {
        *$value
    };
    (real $value:ident) => {
        *$value
    };
    ($pointer:ident $value:ident) => {
        $value
    };
}

macro_rules! export {
    ($($module:ident::$routine:ident as $single:ident, $double:ident
        ($($argument:ident: $kind:ident),* $(,)?);)*) => {$(
        export!(@ $module::$routine as $single(f32) $($argument: $kind),*);
        export!(@ $module::$routine as $double(f64) $($argument: $kind),*);
    )*};
    (@ $module:ident::$routine:ident as $symbol:ident($T:ty) $($argument:ident: $kind:ident),*) => {
        #[doc = concat!(
            "`", stringify!($routine), "` of the reference ", stringify!($module),
            " for `", stringify!($T), "`.\n\n# Safety\nAs the reference demands: scalars point to ",
            "initialised values; arrays are initialised, have the extent that the dimensions, ",
            "leading dimensions and increments describe, and no output overlaps another array."
        )]
        #[unsafe(no_mangle)]
        pub unsafe extern "C" fn $symbol($($argument: foreign!($kind $T)),*) {
            // SAFETY: the generic routine's contract on its arrays is this function's own.
            unsafe { $module::$routine::<$T>($(native!($kind $argument)),*) }
        }
    };
}

export! {
    blas::gemm as sgemm_, dgemm_(
        transa: char, transb: char, m: int, n: int, k: int,
        alpha: real, a: input, lda: int, b: input, ldb: int, beta: real, c: output, ldc: int);
    blas::gemv as sgemv_, dgemv_(
        trans: char, m: int, n: int,
        alpha: real, a: input, lda: int, x: input, incx: int, beta: real, y: output, incy: int);
    blas::symv as ssymv_, dsymv_(
        uplo: char, n: int,
        alpha: real, a: input, lda: int, x: input, incx: int, beta: real, y: output, incy: int);
    blas::syrk as ssyrk_, dsyrk_(
        uplo: char, trans: char, n: int, k: int,
        alpha: real, a: input, lda: int, beta: real, c: output, ldc: int);
    blas::syr2k as ssyr2k_, dsyr2k_(
        uplo: char, trans: char, n: int, k: int,
        alpha: real, a: input, lda: int, b: input, ldb: int, beta: real, c: output, ldc: int);
    lapack::potrf as spotrf_, dpotrf_(uplo: char, n: int, a: output, lda: int, info: info);
    lapack::potrs as spotrs_, dpotrs_(
        uplo: char, n: int, nrhs: int, a: input, lda: int, b: output, ldb: int, info: info);
    lapack::gesv as sgesv_, dgesv_(
        n: int, nrhs: int, a: output, lda: int, ipiv: indices, b: output, ldb: int, info: info);
    lapack::syevr as ssyevr_, dsyevr_(
        jobz: char, range: char, uplo: char, n: int, a: output, lda: int,
        vl: real, vu: real, il: int, iu: int, abstol: real,
        m: info, w: output, z: output, ldz: int, isuppz: indices,
        work: output, lwork: int, iwork: indices, liwork: int, info: info);
    lapack::gesdd as sgesdd_, dgesdd_(
        jobz: char, m: int, n: int, a: output, lda: int,
        s: output, u: output, ldu: int, vt: output, ldvt: int,
        work: output, lwork: int, iwork: indices, info: info);
    lapack::gesvd as sgesvd_, dgesvd_(
        jobu: char, jobvt: char, m: int, n: int, a: output, lda: int,
        s: output, u: output, ldu: int, vt: output, ldvt: int,
        work: output, lwork: int, info: info);
}
