// The tests for one precision `T`, included once for each.

use nalgebra::{DMatrix, DVector};
use proptest::prelude::*;

use crate::common::{Numbers, in_triangle};

/// Units of rounding that a sum over a dimension may have, for bounds of the form
/// `n EPS * size`. OpenBLAS's `syevr` (the method of multiple relatively robust representations)
/// keeps vectors less closely orthogonal.
const EPS: f64 = if cfg!(feature = "openblas-system") { 256.0 } else { 16.0 } * T::EPSILON as f64;

/// Stores a matrix by columns `ld` apart, NaN in the padding.
fn stored(a: &DMatrix<f64>, ld: usize) -> Vec<T> {
    let mut data = vec![T::NAN; (ld * a.ncols()).max(1)];
    for j in 0..a.ncols() {
        for i in 0..a.nrows() {
            data[j * ld + i] = a[(i, j)] as T;
        }
    }
    data
}

/// Stores one triangle of a symmetric matrix, NaN in the other.
fn stored_triangle(uplo: u8, a: &DMatrix<f64>, ld: usize) -> Vec<T> {
    let other = |i, j| if in_triangle(uplo, i, j) { a[(i, j)] } else { f64::NAN };
    stored(&DMatrix::from_fn(a.nrows(), a.ncols(), other), ld)
}

/// The matrix stored by columns `ld` apart; the padding must still be NaN.
fn loaded(data: &[T], rows: usize, cols: usize, ld: usize) -> DMatrix<f64> {
    for (place, value) in data.iter().enumerate() {
        assert!(cols == 0 || place % ld < rows || value.is_nan(), "padding was written");
    }
    DMatrix::from_fn(rows, cols, |i, j| f64::from(data[j * ld + i]))
}

/// The matrix with each element rounded to `T`.
fn rounded(a: &DMatrix<f64>) -> DMatrix<f64> {
    a.map(|value| f64::from(value as T))
}

fn random(numbers: &mut Numbers, rows: usize, cols: usize) -> DMatrix<f64> {
    DMatrix::from_fn(rows, cols, |_, _| numbers.draw())
}

fn orthogonal(numbers: &mut Numbers, n: usize) -> DMatrix<f64> {
    random(numbers, n, n).qr().q()
}

fn positive_definite(numbers: &mut Numbers, n: usize) -> DMatrix<f64> {
    let b = random(numbers, n, n);
    rounded(&(&b * b.transpose() + DMatrix::identity(n, n) * 0.5))
}

/// A positive definite matrix but for its leading minor of order `order`.
fn indefinite_from(numbers: &mut Numbers, n: usize, order: usize) -> DMatrix<f64> {
    let l = random(numbers, n, n).lower_triangle() + DMatrix::identity(n, n) * 2.0;
    let mut signs = DVector::from_element(n, 1.0);
    signs[order - 1] = -1.0;
    &l * DMatrix::from_diagonal(&signs) * l.transpose()
}

/// Spectra that try an iteration in different ways, the largest value about one.
fn spectrum(kind: usize, numbers: &mut Numbers, n: usize) -> DVector<f64> {
    DVector::from_fn(n, |i, _| match kind {
        0 => numbers.draw(),
        1 => 10f64.powf(-16.0 * i as f64 / n as f64),
        2 => 1.0 + f64::from(T::EPSILON) * numbers.draw(),
        3 if i < n / 2 => 1.0,
        3 => 1e-9 * (1.0 + 1e-10 * numbers.draw()),
        4 if i < n / 3 => 1.0,
        4 => 0.0,
        5 => 10f64.powf(-300.0 * i as f64 / n as f64),
        _ => -1.0,
    })
}
const SPECTRA: usize = 7;

fn uplo() -> impl Strategy<Value = u8> {
    prop::sample::select(b"ULul".to_vec())
}

/// A scale at which squares leave the range of `T`.
fn scale() -> impl Strategy<Value = f64> {
    let far = f64::from(T::MAX).sqrt();
    prop_oneof![Just(1.0), Just(far), Just(1.0 / far)]
}

fn is_near(a: &DMatrix<f64>, b: &DMatrix<f64>, error: f64) -> bool {
    a.shape() == b.shape() && a.iter().zip(b).all(|(a, b)| (a - b).abs() <= error)
}

fn is_orthonormal(columns: &DMatrix<f64>) -> bool {
    let n = columns.ncols();
    let error = EPS * columns.nrows() as f64;
    is_near(&(columns.transpose() * columns), &DMatrix::identity(n, n), error)
}

// ---- Cholesky ----

fn factored(uplo: u8, a: &DMatrix<f64>, ld: usize) -> (Vec<T>, i32) {
    let mut factor = stored_triangle(uplo, a, ld);
    let mut info = 99;
    // SAFETY: the array has the extent that the dimensions describe.
    unsafe { potrf(uplo, a.nrows() as i32, &mut factor, ld as i32, &mut info) };
    (factor, info)
}

proptest! {
    #[test]
    fn potrf_factors_and_potrs_solves(
        uplo in uplo(), n in 0..30usize, nrhs in 0..4usize, pad in 0..3usize, seed in any::<u64>(),
    ) {
        let mut numbers = Numbers::new(seed);
        let a = positive_definite(&mut numbers, n);
        let ld = n.max(1) + pad;
        let (factor, info) = factored(uplo, &a, ld);
        prop_assert_eq!(info, 0);

        let f = loaded(&factor, n, n, ld);
        let other = |i, j| in_triangle(uplo, i, j) || f[(i, j)].is_nan();
        prop_assert!((0..n).all(|i| (0..n).all(|j| other(i, j))), "the other triangle was written");
        let product = if in_triangle(uplo, 0, 1) {
            f.upper_triangle().transpose() * f.upper_triangle()
        } else {
            f.lower_triangle() * f.lower_triangle().transpose()
        };
        prop_assert!(is_near(&product, &a, EPS * n as f64 * (n as f64 + 1.0)));

        let x = random(&mut numbers, n, nrhs);
        let mut b = stored(&(&a * &x), ld);
        let mut info = 99;
        // SAFETY: the arrays have the extents that the dimensions describe.
        unsafe {
            potrs(
                uplo, n as i32, nrhs as i32, &factor, ld as i32, &mut b, ld as i32, &mut info,
            );
        }
        prop_assert_eq!(info, 0);
        // The smallest eigenvalue of A is a half at least, the largest n^2 at most.
        let error = EPS * (n * n * n) as f64 * 4.0;
        prop_assert!(is_near(&loaded(&b, n, nrhs, ld), &x, error));
    }

    #[test]
    fn potrf_names_the_first_minor_that_fails(
        uplo in uplo(), n in 1..20usize, at in any::<prop::sample::Index>(), seed in any::<u64>(),
    ) {
        let order = at.index(n) + 1;
        let a = indefinite_from(&mut Numbers::new(seed), n, order);
        prop_assert_eq!(factored(uplo, &a, n).1, order as i32);
        // Positive semidefinite: a pivot that is exactly zero.
        let mut a = DMatrix::identity(n, n);
        a[(order - 1, order - 1)] = 0.0;
        prop_assert_eq!(factored(uplo, &a, n).1, order as i32);
    }
}

#[test]
#[cfg(not(feature = "openblas-system"))] // the reference lets some of these pass
fn potrf_refuses_what_is_not_finite() {
    for bad in [f64::NAN, f64::INFINITY] {
        for (i, j) in [(0, 0), (2, 2), (3, 1), (5, 0)] {
            let mut a = positive_definite(&mut Numbers::new(1), 6);
            a[(i, j)] = bad;
            a[(j, i)] = bad;
            for uplo in *b"UL" {
                assert_eq!(factored(uplo, &a, 6).1, i as i32 + 1);
            }
        }
    }
}

// ---- LU ----

/// Solves A X = B. Returns X, the factors, the pivots and INFO.
fn solved(
    a: &DMatrix<f64>,
    b: &DMatrix<f64>,
    pad: usize,
) -> (DMatrix<f64>, DMatrix<f64>, Vec<i32>, i32) {
    let (n, nrhs) = b.shape();
    let ld = n.max(1) + pad;
    let (mut lu, mut x, mut ipiv, mut info) = (stored(a, ld), stored(b, ld), vec![-1; n], 99);
    // SAFETY: the arrays have the extents that the dimensions describe.
    unsafe {
        gesv(n as i32, nrhs as i32, &mut lu, ld as i32, &mut ipiv, &mut x, ld as i32, &mut info);
    }
    (loaded(&x, n, nrhs, ld), loaded(&lu, n, n, ld), ipiv, info)
}

/// P L U.
fn recomposed(lu: &DMatrix<f64>, ipiv: &[i32]) -> DMatrix<f64> {
    let n = lu.nrows();
    let mut l = lu.lower_triangle();
    l.fill_diagonal(1.0);
    let mut a = l * lu.upper_triangle();
    for i in (0..n).rev() {
        a.swap_rows(i, ipiv[i] as usize - 1);
    }
    a
}

proptest! {
    #[test]
    fn gesv_solves(
        n in 0..30usize, nrhs in 0..4usize, pad in 0..3usize, seed in any::<u64>(),
    ) {
        let mut numbers = Numbers::new(seed);
        let a = rounded(&(random(&mut numbers, n, n)));
        let b = rounded(&random(&mut numbers, n, nrhs));
        let (x, lu, ipiv, info) = solved(&a, &b, pad);
        prop_assert_eq!(info, 0);
        if nrhs == 0 {
            return Ok(()); // OpenBLAS does not even factor
        }
        let n = n as f64;
        let mut l = lu.lower_triangle();
        l.fill_diagonal(1.0);
        prop_assert!(l.amax() <= 1.0 + EPS, "no partial pivoting");
        prop_assert!(is_near(&recomposed(&lu, &ipiv), &a, EPS * n * (1.0 + lu.amax())));
        let error = EPS * n * n * (1.0 + lu.amax()) * (1.0 + x.amax());
        prop_assert!(is_near(&(&a * &x), &b, error));
    }

    /// A column that is exactly dependent gives a pivot that is exactly zero.
    #[test]
    fn gesv_names_the_first_zero_pivot(
        n in 1..20usize, at in any::<prop::sample::Index>(), seed in any::<u64>(),
    ) {
        let mut numbers = Numbers::new(seed);
        let singular = at.index(n);
        let mut a = rounded(&random(&mut numbers, n, n));
        a.column_mut(singular).fill(0.0);
        let b = rounded(&random(&mut numbers, n, 2));
        let (x, lu, ipiv, info) = solved(&a, &b, 0);
        prop_assert_eq!(info, singular as i32 + 1);
        prop_assert_eq!(x, b);
        prop_assert!(is_near(&recomposed(&lu, &ipiv), &a, EPS * n as f64 * (1.0 + lu.amax())));
    }
}

#[test]
#[cfg(not(feature = "openblas-system"))] // the reference lets NaN through
fn gesv_refuses_what_is_not_finite() {
    for bad in [f64::NAN, f64::NEG_INFINITY] {
        for (i, j) in [(0, 0), (5, 2), (2, 5)] {
            let mut a = random(&mut Numbers::new(2), 6, 6);
            a[(i, j)] = bad;
            let b = rounded(&random(&mut Numbers::new(3), 6, 1));
            let (x, _, _, info) = solved(&a, &b, 0);
            assert_eq!(info, j as i32 + 1);
            assert_eq!(x, b);
        }
    }
}

// ---- Eigenvalues ----

/// The eigenvalues and vectors as `syevr` gives them, or its INFO.
fn eigen(
    jobz: u8,
    uplo: u8,
    a: &DMatrix<f64>,
    pad: usize,
) -> Result<(DVector<f64>, DMatrix<f64>), i32> {
    let n = a.nrows();
    let ld = n.max(1) + pad;
    let mut data = stored_triangle(uplo, a, ld);
    let (mut w, mut z) = (vec![T::NAN; n], vec![T::NAN; ld * n.max(1)]);
    let (mut work, mut iwork, mut isuppz) = (vec![0.0; 1], vec![0; 1], vec![0; 2 * n.max(1)]);
    let (mut lwork, mut liwork) = (-1, -1);
    for _ in ["query", "compute"] {
        let (mut m, mut info) = (0, 99);
        // SAFETY: the arrays have the extents that the dimensions and the query describe.
        unsafe {
            syevr(
                jobz,
                b'A',
                uplo,
                n as i32,
                &mut data,
                ld as i32,
                0.0,
                0.0,
                0,
                0,
                -1.0,
                &mut m,
                &mut w,
                &mut z,
                ld as i32,
                &mut isuppz,
                &mut work,
                lwork,
                &mut iwork,
                liwork,
                &mut info,
            );
        }
        if info != 0 {
            return Err(info);
        }
        if lwork > 0 {
            assert_eq!(m, n as i32);
        }
        (lwork, liwork) = (work[0] as i32, iwork[0]);
        work.resize(lwork as usize, 0.0);
        iwork.resize(liwork as usize, 0);
    }
    let values = DVector::from_iterator(n, w.iter().map(|&value| f64::from(value)));
    let vectors = match jobz {
        b'V' => loaded(&z, n, n, ld),
        _ => DMatrix::zeros(n, 0),
    };
    Ok((values, vectors))
}

/// Checks what the decomposition of `a` promises, relative to the size of its elements.
fn check_eigen(uplo: u8, a: &DMatrix<f64>, pad: usize) -> Result<(), TestCaseError> {
    let (values, vectors) =
        eigen(b'V', uplo, a, pad).map_err(|info| TestCaseError::fail(format!("INFO {info}")))?;
    let error = EPS * a.nrows() as f64 * a.amax();
    prop_assert!(values.as_slice().is_sorted(), "not ascending: {values}");
    prop_assert!(is_orthonormal(&vectors), "not orthonormal: {vectors}");
    let right = &vectors * DMatrix::from_diagonal(&values);
    let residual = (a * &vectors - right).amax();
    prop_assert!(residual <= error, "A Z - Z W = {residual:e} > {error:e}");
    let only =
        eigen(b'N', uplo, a, pad).map_err(|info| TestCaseError::fail(format!("INFO {info}")))?;
    prop_assert!((only.0 - values).amax() <= 2.0 * error);
    Ok(())
}

proptest! {
    #[test]
    fn syevr_decomposes(
        uplo in uplo(), kind in 0..SPECTRA, n in 0..30usize, pad in 0..3usize, scale in scale(),
        seed in any::<u64>(),
    ) {
        let mut numbers = Numbers::new(seed);
        let q = orthogonal_or_empty(&mut numbers, n);
        let values = spectrum(kind, &mut numbers, n);
        let a = &q * DMatrix::from_diagonal(&values) * q.transpose();
        check_eigen(uplo, &rounded(&((&a + a.transpose()) * 0.5 * scale)), pad)?;
    }

    /// Couplings of all sizes between equal, graded or absent diagonal elements.
    #[test]
    fn syevr_decomposes_graded_tridiagonals(
        uplo in uplo(), kind in 0..SPECTRA, n in 1..30usize, seed in any::<u64>(),
    ) {
        let mut numbers = Numbers::new(seed);
        let mut a = DMatrix::from_diagonal(&spectrum(kind, &mut numbers, n));
        for i in 1..n {
            let coupling = numbers.draw() * 10f64.powf(-160.0 * (1.0 + numbers.draw()));
            a[(i, i - 1)] = coupling;
            a[(i - 1, i)] = coupling;
        }
        check_eigen(uplo, &rounded(&a), 0)?;
    }
}

fn orthogonal_or_empty(numbers: &mut Numbers, n: usize) -> DMatrix<f64> {
    if n == 0 { DMatrix::zeros(0, 0) } else { orthogonal(numbers, n) }
}

#[test]
fn syevr_knows_repeated_and_zero_eigenvalues() {
    for n in [1, 2, 3, 7] {
        check_eigen(b'U', &DMatrix::zeros(n, n), 0).expect("zero");
        check_eigen(b'L', &DMatrix::identity(n, n), 0).expect("identity");
        check_eigen(b'U', &DMatrix::from_element(n, n, 1.0), 0).expect("rank one");
    }
    let (values, _) = eigen(b'N', b'U', &DMatrix::from_element(6, 6, 1.0), 0).expect("rank one");
    assert!(
        (values - DVector::from_column_slice(&[0.0, 0.0, 0.0, 0.0, 0.0, 6.0])).amax() < 10.0 * EPS
    );
}

#[test]
#[cfg(not(feature = "openblas-system"))] // the reference may not come back from NaN
fn syevr_refuses_what_is_not_finite_and_parts_of_the_spectrum() {
    for bad in [f64::NAN, f64::INFINITY] {
        for (i, j) in [(0, 0), (4, 2)] {
            let mut a = DMatrix::identity(6, 6);
            a[(i, j)] = bad;
            a[(j, i)] = bad;
            for jobz in *b"NV" {
                assert!(eigen(jobz, b'U', &a, 0).is_err_and(|info| info > 0));
            }
        }
    }
    for range in *b"VI" {
        let (mut a, mut w, mut z, mut m, mut info) = ([1.0], [7.0], [7.0], 0, 0);
        // SAFETY: the arrays have the extents that the dimensions describe.
        unsafe {
            syevr(
                b'V',
                range,
                b'U',
                1,
                &mut a,
                1,
                0.0,
                2.0,
                1,
                1,
                -1.0,
                &mut m,
                &mut w,
                &mut z,
                1,
                &mut [0; 2],
                &mut [0.0],
                1,
                &mut [0],
                1,
                &mut info,
            );
        }
        assert_eq!((info, w, z), (-2, [7.0], [7.0]));
    }
}

// ---- Singular values ----

/// The routine that decomposes: both do the same.
#[derive(Clone, Copy, Debug)]
enum Routine {
    Gesdd,
    Gesvd,
}

/// U, the singular values and VT.
type Decomposition = (DMatrix<f64>, DVector<f64>, DMatrix<f64>);

/// The decomposition, or INFO.
fn svd(routine: Routine, job: u8, a: &DMatrix<f64>, pad: usize) -> Result<Decomposition, i32> {
    let (m, n) = a.shape();
    let k = m.min(n);
    let (lda, ldvt) = (m.max(1) + pad, k.max(1) + pad);
    let mut data = stored(a, lda);
    let mut s = vec![T::NAN; k];
    let (mut u, mut vt) = (vec![T::NAN; lda * k.max(1)], vec![T::NAN; ldvt * n.max(1)]);
    let (mut work, mut iwork, mut lwork) = (vec![0.0; 1], vec![0; 8 * k.max(1)], -1);
    let (rows, cols, ldu, ldv) = (m as i32, n as i32, lda as i32, ldvt as i32);
    for _ in ["query", "compute"] {
        let mut info = 99;
        // SAFETY: the arrays have the extents that the dimensions and the query describe.
        unsafe {
            match routine {
                Routine::Gesdd => gesdd(
                    job, rows, cols, &mut data, ldu, &mut s, &mut u, ldu, &mut vt, ldv, &mut work,
                    lwork, &mut iwork, &mut info,
                ),
                Routine::Gesvd => gesvd(
                    job, job, rows, cols, &mut data, ldu, &mut s, &mut u, ldu, &mut vt, ldv,
                    &mut work, lwork, &mut info,
                ),
            }
        }
        if info != 0 {
            return Err(info);
        }
        lwork = work[0] as i32;
        work.resize(lwork as usize, 0.0);
    }
    let values = DVector::from_iterator(k, s.iter().map(|&value| f64::from(value)));
    match job {
        b'S' => Ok((loaded(&u, m, k, lda), values, loaded(&vt, k, n, ldvt))),
        _ => Ok((DMatrix::zeros(m, 0), values, DMatrix::zeros(0, n))),
    }
}

/// Checks what the decomposition of `a` promises, relative to the size of its elements.
fn check_svd(routine: Routine, a: &DMatrix<f64>, pad: usize) -> Result<(), TestCaseError> {
    let failed = |info| TestCaseError::fail(format!("INFO {info}"));
    let (u, values, vt) = svd(routine, b'S', a, pad).map_err(failed)?;
    let error = EPS * a.len() as f64 * a.amax();
    let descending = values.iter().rev().is_sorted();
    prop_assert!(descending && values.iter().all(|&value| value >= 0.0), "{values}");
    prop_assert!(is_orthonormal(&u) && is_orthonormal(&vt.transpose()));
    let residual = (&u * DMatrix::from_diagonal(&values) * &vt - a).amax();
    prop_assert!(residual <= error, "U S VT - A = {residual:e} > {error:e}");
    let only = svd(routine, b'N', a, pad).map_err(failed)?;
    prop_assert!((only.1 - values).amax() <= 2.0 * error);
    Ok(())
}

proptest! {
    #[test]
    fn gesdd_and_gesvd_decompose(
        routine in prop::sample::select(vec![Routine::Gesdd, Routine::Gesvd]),
        kind in 0..SPECTRA, (m, n) in (1..30usize, 1..30usize), pad in 0..3usize, scale in scale(),
        seed in any::<u64>(),
    ) {
        let mut numbers = Numbers::new(seed);
        let (u, v) = (orthogonal(&mut numbers, m), orthogonal(&mut numbers, n));
        let mut middle = DMatrix::zeros(m, n);
        middle.set_diagonal(&spectrum(kind, &mut numbers, m.min(n)));
        check_svd(routine, &rounded(&(u * middle * v.transpose() * scale)), pad)?;
    }

    #[test]
    fn gesdd_and_gesvd_decompose_graded_bidiagonals(
        routine in prop::sample::select(vec![Routine::Gesdd, Routine::Gesvd]),
        kind in 0..SPECTRA, n in 1..30usize, seed in any::<u64>(),
    ) {
        let mut numbers = Numbers::new(seed);
        let mut a = DMatrix::from_diagonal(&spectrum(kind, &mut numbers, n));
        for i in 1..n {
            a[(i - 1, i)] = numbers.draw() * 10f64.powf(-160.0 * (1.0 + numbers.draw()));
        }
        check_svd(routine, &rounded(&a), 0)?;
        check_svd(routine, &rounded(&a.transpose()), 0)?;
    }
}

#[test]
fn gesdd_and_gesvd_know_rank_deficiency() {
    for routine in [Routine::Gesdd, Routine::Gesvd] {
        for (m, n) in [(1, 1), (3, 5), (6, 21), (21, 6), (8, 8)] {
            check_svd(routine, &DMatrix::zeros(m, n), 0).expect("zero");
            check_svd(routine, &DMatrix::identity(m, n), 0).expect("identity");
            let ones = DMatrix::from_element(m, n, 1.0);
            check_svd(routine, &ones, 0).expect("rank one");
            let (_, values, _) = svd(routine, b'N', &ones, 0).expect("rank one");
            assert!((values[0] - ((m * n) as f64).sqrt()).abs() < 100.0 * EPS);
            assert!(values.iter().skip(1).all(|&value| value < 100.0 * EPS));
        }
        assert!(svd(routine, b'S', &DMatrix::zeros(0, 3), 0).is_ok());
    }
}

#[test]
#[cfg(not(feature = "openblas-system"))] // the reference's own answers to NaN and other jobs
fn gesdd_and_gesvd_refuse_what_is_not_finite_and_other_jobs() {
    for routine in [Routine::Gesdd, Routine::Gesvd] {
        for bad in [f64::NAN, f64::INFINITY] {
            let mut a = DMatrix::identity(6, 5);
            a[(4, 2)] = bad;
            for job in *b"NS" {
                assert!(svd(routine, job, &a, 0).is_err_and(|info| info > 0));
            }
        }
        for job in *b"AO" {
            assert_eq!(svd(routine, job, &DMatrix::identity(4, 4), 0).err(), Some(-1));
        }
    }
}

// ---- INFO of illegal arguments ----

#[test]
fn illegal_arguments_are_numbered() {
    let (mut a, mut b, mut w) = ([1.0; 4], [7.0; 4], [7.0; 4]);
    let mut i = [0; 32];
    // SAFETY: no routine reads or writes an array once an argument is illegal.
    unsafe {
        for (uplo, n, lda, expected) in [(b'X', 2, 2, -1), (b'U', -1, 2, -2), (b'U', 2, 1, -4)] {
            let mut info = 0;
            potrf(uplo, n, &mut a, lda, &mut info);
            assert_eq!(info, expected);
        }
        for (uplo, n, nrhs, lda, ldb, expected) in [
            (b'X', 2, 2, 2, 2, -1),
            (b'U', -1, 2, 2, 2, -2),
            (b'U', 2, -1, 2, 2, -3),
            (b'U', 2, 2, 1, 2, -5),
            (b'U', 2, 2, 2, 1, -7),
        ] {
            let mut info = 0;
            potrs(uplo, n, nrhs, &a, lda, &mut b, ldb, &mut info);
            assert_eq!(info, expected);
        }
        for (n, nrhs, lda, ldb, expected) in
            [(-1, 2, 2, 2, -1), (2, -1, 2, 2, -2), (2, 2, 1, 2, -4), (2, 2, 2, 1, -7)]
        {
            let mut info = 0;
            gesv(n, nrhs, &mut a, lda, &mut i, &mut b, ldb, &mut info);
            assert_eq!(info, expected);
        }
        for (jobz, range, uplo, n, lda, ldz, lwork, liwork, expected) in [
            (b'X', b'A', b'U', 2, 2, 2, 99, 99, -1),
            (b'V', b'X', b'U', 2, 2, 2, 99, 99, -2),
            (b'V', b'A', b'X', 2, 2, 2, 99, 99, -3),
            (b'V', b'A', b'U', -1, 2, 2, 99, 99, -4),
            (b'V', b'A', b'U', 2, 1, 2, 99, 99, -6),
            (b'V', b'A', b'U', 2, 2, 1, 99, 99, -15),
            (b'V', b'A', b'U', 2, 2, 2, 0, 99, -18),
            (b'V', b'A', b'U', 2, 2, 2, 99, 0, -20),
        ] {
            let (mut m, mut info, mut isuppz) = (0, 0, [0; 4]);
            syevr(
                jobz,
                range,
                uplo,
                n,
                &mut a,
                lda,
                0.0,
                0.0,
                0,
                0,
                0.0,
                &mut m,
                &mut w,
                &mut b,
                ldz,
                &mut isuppz,
                &mut [0.0; 99],
                lwork,
                &mut i,
                liwork,
                &mut info,
            );
            assert_eq!(info, expected);
        }
        for (job, m, n, lda, ldu, ldvt, lwork, expected) in [
            (b'X', 2, 2, 2, 2, 2, 99, -1),
            (b'S', -1, 2, 2, 2, 2, 99, -2),
            (b'S', 2, -1, 2, 2, 2, 99, -3),
            (b'S', 2, 2, 1, 2, 2, 99, -5),
            (b'S', 2, 2, 2, 1, 2, 99, -8),
            (b'S', 2, 2, 2, 2, 1, 99, -10),
            (b'S', 2, 2, 2, 2, 2, 0, -12),
        ] {
            let (mut info, mut vt, mut work) = (0, [7.0; 4], [0.0; 99]);
            gesdd(
                job, m, n, &mut a, lda, &mut w, &mut b, ldu, &mut vt, ldvt, &mut work, lwork,
                &mut i, &mut info,
            );
            assert_eq!(info, expected);
            // `gesvd` has one more job in front.
            gesvd(
                job, b'S', m, n, &mut a, lda, &mut w, &mut b, ldu, &mut vt, ldvt, &mut work, lwork,
                &mut info,
            );
            assert_eq!(info, if job == b'X' { -1 } else { expected - 1 });
            assert_eq!(vt, [7.0; 4]);
        }
    }
    assert_eq!((a, b, w), ([1.0; 4], [7.0; 4], [7.0; 4]));
}
