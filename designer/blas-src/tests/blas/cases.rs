// The tests for one precision `T`, included once for each.

use proptest::prelude::*;

use crate::common::{Numbers, in_triangle};

/// A matrix as the caller stores it: by columns `ld` apart, NaN where there is no element.
#[derive(Clone)]
struct Stored {
    data: Vec<T>,
    ld: usize,
}

impl Stored {
    fn new(
        (rows, cols): (usize, usize),
        pad: usize,
        mut element: impl FnMut(usize, usize) -> T,
    ) -> Self {
        let ld = rows.max(1) + pad;
        let mut data = vec![T::NAN; (ld * cols).max(1)];
        for j in 0..cols {
            for i in 0..rows {
                data[j * ld + i] = element(i, j);
            }
        }
        Stored { data, ld }
    }

    fn at(&self, i: usize, j: usize) -> f64 {
        f64::from(self.data[j * self.ld + i])
    }

    fn ld(&self) -> i32 {
        self.ld as i32
    }
}

/// op(A) as an element function.
fn op(trans: u8, a: &Stored) -> impl Fn(usize, usize) -> f64 + '_ {
    move |i, j| if trans.eq_ignore_ascii_case(&b'N') { a.at(i, j) } else { a.at(j, i) }
}

/// The shape in which op(A) of `rows` x `cols` is stored.
fn stored_shape(trans: u8, rows: usize, cols: usize) -> (usize, usize) {
    if trans.eq_ignore_ascii_case(&b'N') { (rows, cols) } else { (cols, rows) }
}

/// alpha times the sum of the products, plus beta times what was there; and the rounding error
/// that a sum in any order may have.
fn combine(alpha: T, products: impl Iterator<Item = (f64, f64)>, beta: T, before: T) -> (f64, f64) {
    let (alpha, beta) = (f64::from(alpha), f64::from(beta));
    let (mut sum, mut size, mut count) = (0.0, 0.0, 4.0);
    if alpha != 0.0 {
        for (a, b) in products {
            sum += alpha * a * b;
            size += (alpha * a * b).abs();
            count += 2.0;
        }
    }
    if beta != 0.0 {
        sum += beta * f64::from(before);
        size += (beta * f64::from(before)).abs();
    }
    (sum, count * f64::from(T::EPSILON) * size)
}

/// Checks the elements of `after` that `expected` speaks of, and that no other has changed.
fn check(
    after: &[T],
    before: &[T],
    expected: impl Fn(usize) -> Option<(f64, f64)>,
) -> Result<(), TestCaseError> {
    for (place, (after, before)) in after.iter().zip(before).enumerate() {
        match expected(place) {
            Some((value, error)) => {
                prop_assert!(
                    (f64::from(*after) - value).abs() <= error,
                    "place {}: {} is not {} +- {}",
                    place,
                    after,
                    value,
                    error
                );
            }
            None => prop_assert_eq!(after.to_bits(), before.to_bits(), "place {}", place),
        }
    }
    Ok(())
}

/// The place in its array of element `i` of a vector.
fn place(i: usize, n: usize, inc: i32) -> usize {
    let step = inc.unsigned_abs() as usize;
    step * if inc > 0 { i } else { n - 1 - i }
}

/// A vector in its array, NaN between the elements.
fn vector(n: usize, inc: i32, mut element: impl FnMut() -> T) -> Vec<T> {
    let mut data = vec![T::NAN; n.max(1) * inc.unsigned_abs() as usize];
    for i in 0..n {
        data[place(i, n, inc)] = element();
    }
    data
}

fn trans() -> impl Strategy<Value = u8> {
    prop::sample::select(b"NTCntc".to_vec())
}

fn uplo() -> impl Strategy<Value = u8> {
    prop::sample::select(b"ULul".to_vec())
}

/// A factor, zero and one among them.
fn factor() -> impl Strategy<Value = T> {
    prop_oneof![Just(0.0), Just(1.0), -3.0..3.0 as T]
}

/// A dimension: nalgebra changes its method at 6, and its kernels work in blocks of 4 to 16.
fn dimension() -> impl Strategy<Value = usize> {
    prop_oneof![0..8usize, 8..40usize]
}

fn increment() -> impl Strategy<Value = i32> {
    prop::sample::select(vec![-3, -1, 1, 2])
}

/// A number, or NaN where the factor is zero.
fn number(numbers: &mut Numbers, factor: T) -> T {
    if factor == 0.0 { T::NAN } else { numbers.draw() as T }
}

proptest! {
    #[test]
    fn gemm_multiplies(
        (transa, transb) in (trans(), trans()),
        (m, n, k) in (dimension(), dimension(), dimension()),
        (alpha, beta) in (factor(), factor()),
        pad in (0..3usize, 0..3usize, 0..3usize),
        seed in any::<u64>(),
    ) {
        let mut numbers = Numbers::new(seed);
        let a = Stored::new(stored_shape(transa, m, k), pad.0, |_, _| number(&mut numbers, alpha));
        let b = Stored::new(stored_shape(transb, k, n), pad.1, |_, _| number(&mut numbers, alpha));
        let c = Stored::new((m, n), pad.2, |_, _| number(&mut numbers, beta));
        let mut after = c.data.clone();
        // SAFETY: the arrays have the extents that the dimensions describe.
        unsafe {
            gemm(
                transa, transb, m as i32, n as i32, k as i32, alpha, &a.data, a.ld(), &b.data,
                b.ld(), beta, &mut after, c.ld(),
            );
        }
        let (opa, opb) = (op(transa, &a), op(transb, &b));
        check(&after, &c.data, |place| {
            let (i, j) = (place % c.ld, place / c.ld);
            let products = (0..k).map(|l| (opa(i, l), opb(l, j)));
            (i < m && j < n).then(|| combine(alpha, products, beta, c.data[place]))
        })?;
    }

    #[test]
    fn gemv_multiplies(
        trans in trans(),
        (m, n) in (dimension(), dimension()),
        (alpha, beta) in (factor(), factor()),
        pad in 0..3usize,
        (incx, incy) in (increment(), increment()),
        seed in any::<u64>(),
    ) {
        let mut numbers = Numbers::new(seed);
        let a = Stored::new((m, n), pad, |_, _| number(&mut numbers, alpha));
        let (rows, cols) = stored_shape(trans, m, n);
        let x = vector(cols, incx, || number(&mut numbers, alpha));
        let y = vector(rows, incy, || number(&mut numbers, beta));
        let mut after = y.clone();
        // SAFETY: the arrays have the extents that the dimensions describe.
        unsafe {
            gemv(
                trans, m as i32, n as i32, alpha, &a.data, a.ld(), &x, incx, beta, &mut after, incy,
            );
        }
        let opa = op(trans, &a);
        check(&after, &y, |at| {
            // An empty A leaves y as it is.
            let i = (0..rows).find(|&i| place(i, rows, incy) == at).filter(|_| cols > 0)?;
            let products = (0..cols).map(|l| (opa(i, l), f64::from(x[place(l, cols, incx)])));
            Some(combine(alpha, products, beta, y[at]))
        })?;
    }

    #[test]
    fn symv_reads_one_triangle(
        uplo in uplo(),
        n in dimension(),
        (alpha, beta) in (factor(), factor()),
        pad in 0..3usize,
        (incx, incy) in (increment(), increment()),
        seed in any::<u64>(),
    ) {
        let mut numbers = Numbers::new(seed);
        let a = Stored::new((n, n), pad, |i, j| {
            if in_triangle(uplo, i, j) { number(&mut numbers, alpha) } else { T::NAN }
        });
        let x = vector(n, incx, || number(&mut numbers, alpha));
        let y = vector(n, incy, || number(&mut numbers, beta));
        let mut after = y.clone();
        // SAFETY: the arrays have the extents that the dimensions describe.
        unsafe { symv(uplo, n as i32, alpha, &a.data, a.ld(), &x, incx, beta, &mut after, incy) };
        let symmetric = |i, j| if in_triangle(uplo, i, j) { a.at(i, j) } else { a.at(j, i) };
        check(&after, &y, |at| {
            let i = (0..n).find(|&i| place(i, n, incy) == at)?;
            let products = (0..n).map(|l| (symmetric(i, l), f64::from(x[place(l, n, incx)])));
            Some(combine(alpha, products, beta, y[at]))
        })?;
    }

    #[test]
    fn syrk_and_syr2k_write_one_triangle(
        (uplo, trans) in (uplo(), trans()),
        (n, k) in (dimension(), dimension()),
        (alpha, beta) in (factor(), factor()),
        pad in (0..3usize, 0..3usize, 0..3usize),
        seed in any::<u64>(),
    ) {
        let mut numbers = Numbers::new(seed);
        let shape = stored_shape(trans, n, k);
        let a = Stored::new(shape, pad.0, |_, _| number(&mut numbers, alpha));
        let b = Stored::new(shape, pad.1, |_, _| number(&mut numbers, alpha));
        let c = Stored::new((n, n), pad.2, |i, j| {
            if in_triangle(uplo, i, j) { number(&mut numbers, beta) } else { T::NAN }
        });
        let (mut after, mut after2) = (c.data.clone(), c.data.clone());
        // SAFETY: the arrays have the extents that the dimensions describe.
        unsafe {
            syrk(
                uplo, trans, n as i32, k as i32, alpha, &a.data, a.ld(), beta, &mut after, c.ld(),
            );
            syr2k(
                uplo, trans, n as i32, k as i32, alpha, &a.data, a.ld(), &b.data, b.ld(), beta,
                &mut after2, c.ld(),
            );
        }
        let (opa, opb) = (op(trans, &a), op(trans, &b));
        let element = |place| {
            let (i, j) = (place % c.ld, place / c.ld);
            (i < n && j < n && in_triangle(uplo, i, j)).then_some((i, j))
        };
        check(&after, &c.data, |place| {
            let (i, j) = element(place)?;
            let products = (0..k).map(|l| (opa(i, l), opa(j, l)));
            Some(combine(alpha, products, beta, c.data[place]))
        })?;
        check(&after2, &c.data, |place| {
            let (i, j) = element(place)?;
            let products = (0..k).flat_map(|l| [(opa(i, l), opb(j, l)), (opb(i, l), opa(j, l))]);
            Some(combine(alpha, products, beta, c.data[place]))
        })?;
    }
}

/// An illegal argument, one at a time, leaves the output as it is.
#[test]
fn illegal_arguments_change_nothing() {
    let (a, one) = ([1.0; 4], 1.0);
    let mut c = [7.0; 4];
    // SAFETY: no routine reads or writes anything once an argument is illegal.
    unsafe {
        for (ta, tb, m, n, k, lda, ldb, ldc) in [
            (b'X', b'N', 2, 2, 2, 2, 2, 2),
            (b'N', b'X', 2, 2, 2, 2, 2, 2),
            (b'N', b'N', -1, 2, 2, 2, 2, 2),
            (b'N', b'N', 2, -1, 2, 2, 2, 2),
            (b'N', b'N', 2, 2, -1, 2, 2, 2),
            (b'N', b'N', 2, 2, 2, 1, 2, 2),
            (b'T', b'N', 1, 2, 2, 1, 2, 2),
            (b'N', b'N', 2, 2, 2, 2, 1, 2),
            (b'N', b'T', 2, 2, 1, 2, 1, 2),
            (b'N', b'N', 2, 2, 2, 2, 2, 1),
            (b'N', b'N', 0, 2, 2, 0, 2, 2),
        ] {
            gemm(ta, tb, m, n, k, one, &a, lda, &a, ldb, one, &mut c, ldc);
        }
        for (trans, m, n, lda, incx, incy) in [
            (b'X', 2, 2, 2, 1, 1),
            (b'N', -1, 2, 2, 1, 1),
            (b'N', 2, -1, 2, 1, 1),
            (b'N', 2, 2, 1, 1, 1),
            (b'N', 2, 2, 2, 0, 1),
            (b'N', 2, 2, 2, 1, 0),
        ] {
            gemv(trans, m, n, one, &a, lda, &a, incx, one, &mut c, incy);
        }
        for (uplo, n, lda, incx, incy) in [
            (b'X', 2, 2, 1, 1),
            (b'U', -1, 2, 1, 1),
            (b'U', 2, 1, 1, 1),
            (b'U', 2, 2, 0, 1),
            (b'U', 2, 2, 1, 0),
        ] {
            symv(uplo, n, one, &a, lda, &a, incx, one, &mut c, incy);
        }
        for (uplo, trans, n, k, lda, ldc) in [
            (b'X', b'N', 2, 2, 2, 2),
            (b'U', b'X', 2, 2, 2, 2),
            (b'U', b'N', -1, 2, 2, 2),
            (b'U', b'N', 2, -1, 2, 2),
            (b'U', b'N', 2, 2, 1, 2),
            (b'U', b'T', 1, 2, 1, 2),
            (b'U', b'N', 2, 2, 2, 1),
        ] {
            syrk(uplo, trans, n, k, one, &a, lda, one, &mut c, ldc);
            syr2k(uplo, trans, n, k, one, &a, lda, &a, 2, one, &mut c, ldc);
        }
        syr2k(b'U', b'N', 2, 2, one, &a, 2, &a, 1, one, &mut c, 2);
    }
    assert_eq!(c, [7.0; 4]);
}
