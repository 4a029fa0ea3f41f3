//! Arithmetic on four numbers at a time, by AVX2 and FMA where the processor has them.
//!
//! A [`Kernel`] is written once and compiled twice; [`run`] asks the processor and picks. The two round differently in
//! the last bits (FMA rounds once), so that results are the same from run to run and whatever the thread count, but not
//! on a machine without FMA. A kernel that only writes `a * b + c` is compiled to wide arithmetic too, and rounds the same
//! everywhere.

/// Four numbers in a register.
pub trait Lanes: Copy {
    type Four: Copy;

    fn load(self, numbers: &[f64; 4]) -> Self::Four;

    fn store(self, four: Self::Four, numbers: &mut [f64; 4]);

    /// factor · x + sum.
    fn multiply_add(self, factor: f64, x: Self::Four, sum: Self::Four) -> Self::Four;

    /// sum − factor · x.
    fn multiply_subtract(self, factor: f64, x: Self::Four, sum: Self::Four) -> Self::Four;

    /// factor · x.
    fn multiply(self, factor: f64, x: Self::Four) -> Self::Four;

    #[inline(always)]
    fn load_row<const Q: usize>(self, row: &[[f64; 4]; Q]) -> [Self::Four; Q] {
        std::array::from_fn(
            #[inline(always)]
            |q| self.load(&row[q]),
        )
    }

    #[inline(always)]
    fn store_row<const Q: usize>(self, fours: [Self::Four; Q], row: &mut [[f64; 4]; Q]) {
        for q in 0..Q {
            self.store(fours[q], &mut row[q]);
        }
    }
}

/// A computation on lanes; `compute` and all it calls must be `#[inline(always)]`, or it is compiled without AVX2.
pub trait Kernel {
    fn compute<L: Lanes>(self, lanes: L);
}

/// Runs a kernel with the widest arithmetic the processor has.
pub fn run(kernel: impl Kernel) {
    #[cfg(target_arch = "x86_64")]
    if let Some(simd) = pulp::x86::V3::try_new() {
        return pulp::Simd::vectorize(simd, avx2::Compiled { kernel, simd });
    }
    kernel.compute(Portable);
}

/// Runs a computation compiled for the widest registers the processor has; it and all it calls must be
/// `#[inline(always)]`. Operations are neither contracted nor reordered, so that the result is the same on any processor.
pub fn vectorised<R>(computation: impl FnOnce() -> R) -> R {
    #[cfg(target_arch = "x86_64")]
    if let Some(simd) = pulp::x86::V3::try_new() {
        return pulp::Simd::vectorize(simd, computation);
    }
    computation()
}

#[derive(Clone, Copy)]
struct Portable;

impl Lanes for Portable {
    type Four = [f64; 4];

    #[inline(always)]
    fn load(self, numbers: &[f64; 4]) -> [f64; 4] {
        *numbers
    }

    #[inline(always)]
    fn store(self, four: [f64; 4], numbers: &mut [f64; 4]) {
        *numbers = four;
    }

    #[inline(always)]
    fn multiply_add(self, factor: f64, x: [f64; 4], sum: [f64; 4]) -> [f64; 4] {
        [factor * x[0] + sum[0], factor * x[1] + sum[1], factor * x[2] + sum[2], factor * x[3] + sum[3]]
    }

    #[inline(always)]
    fn multiply_subtract(self, factor: f64, x: [f64; 4], sum: [f64; 4]) -> [f64; 4] {
        self.multiply_add(-factor, x, sum)
    }

    #[inline(always)]
    fn multiply(self, factor: f64, x: [f64; 4]) -> [f64; 4] {
        x.map(|x| factor * x)
    }
}

#[cfg(target_arch = "x86_64")]
mod avx2 {
    use pulp::{NullaryFnOnce, cast, f64x4, x86::V3};

    use super::{Kernel, Lanes};

    pub struct Compiled<K> {
        pub kernel: K,
        pub simd: V3,
    }

    impl<K: Kernel> NullaryFnOnce for Compiled<K> {
        type Output = ();

        #[inline(always)]
        fn call(self) {
            self.kernel.compute(self.simd);
        }
    }

    impl Lanes for V3 {
        type Four = f64x4;

        #[inline(always)]
        fn load(self, numbers: &[f64; 4]) -> f64x4 {
            cast(*numbers)
        }

        #[inline(always)]
        fn store(self, four: f64x4, numbers: &mut [f64; 4]) {
            *numbers = cast(four);
        }

        #[inline(always)]
        fn multiply_add(self, factor: f64, x: f64x4, sum: f64x4) -> f64x4 {
            self.mul_add_f64x4(self.splat_f64x4(factor), x, sum)
        }

        #[inline(always)]
        fn multiply_subtract(self, factor: f64, x: f64x4, sum: f64x4) -> f64x4 {
            self.negate_mul_add_f64x4(self.splat_f64x4(factor), x, sum)
        }

        #[inline(always)]
        fn multiply(self, factor: f64, x: f64x4) -> f64x4 {
            self.mul_f64x4(self.splat_f64x4(factor), x)
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    struct Axpy<'a>(f64, &'a [[f64; 4]; 2], &'a mut [[f64; 4]; 2]);

    impl Kernel for Axpy<'_> {
        #[inline(always)]
        fn compute<L: Lanes>(self, lanes: L) {
            let (x, y) = (lanes.load_row(self.1), lanes.load_row(self.2));
            let sum = [lanes.multiply_add(self.0, x[0], y[0]), lanes.multiply_add(self.0, x[1], y[1])];
            lanes.store_row(sum, self.2);
        }
    }

    #[test]
    fn both_arithmetics_agree() {
        let x = [[1.0, -2.0, 0.3, 4.0], [0.1, 6.0, 7.5, -8.0]];
        let start = [[0.5, 1.5, -2.5, 3.5], [1e3, 0.0, 2.0, 0.25]];
        let (mut fast, mut portable) = (start, start);
        run(Axpy(1.7, &x, &mut fast));
        Axpy(1.7, &x, &mut portable).compute(Portable);
        for (a, b) in fast.as_flattened().iter().zip(portable.as_flattened()) {
            assert!((a - b).abs() <= 1e-12 * b.abs().max(1.0));
        }
    }
}
