//! What memory can do: long arrays copied and combined, as in the STREAM benchmark.

use rayon::prelude::*;

use crate::Samples;

/// Numbers per array: 256 MiB each, far beyond any cache.
const LEN: usize = 32 << 20;

/// Times of moving whole arrays, for one number of threads.
#[derive(Default)]
pub(crate) struct Bandwidth {
    copy: Samples,
    triad: Samples,
    fresh: Samples,
}

impl Bandwidth {
    /// Measures once, on the threads of the current pool.
    pub(crate) fn measure(&mut self, threads: usize) {
        let part = LEN / threads;
        let a = vec![1.0; LEN];
        let b = vec![2.0; LEN];
        let mut c: Vec<f64> = Vec::new();
        // The first writing of an array also makes the system find pages for it.
        self.fresh.time(|| {
            c = vec![0.0; LEN];
            c.par_chunks_mut(part).for_each(|c| c.fill(3.0));
        });
        self.copy.time(|| {
            c.par_chunks_mut(part)
                .zip(a.par_chunks(part))
                .for_each(|(c, a)| c.iter_mut().zip(a).for_each(|(c, a)| *c = *a));
        });
        self.triad.time(|| {
            c.par_chunks_mut(part).zip(a.par_chunks(part).zip(b.par_chunks(part))).for_each(
                |(c, (a, b))| {
                    c.iter_mut().zip(a.iter().zip(b)).for_each(|(c, (a, b))| *c = a + 3.0 * b);
                },
            );
        });
        std::hint::black_box(c);
    }

    /// Bytes per nanosecond, which is GB/s: one array read, one written.
    pub(crate) fn copy(&self) -> f64 {
        (16 * LEN) as f64 / (1e9 * self.copy.best())
    }

    /// Bytes per nanosecond: two arrays read, one written.
    pub(crate) fn triad(&self) -> f64 {
        (24 * LEN) as f64 / (1e9 * self.triad.best())
    }

    /// Bytes per nanosecond: one array written that was never written before.
    pub(crate) fn fresh(&self) -> f64 {
        (8 * LEN) as f64 / (1e9 * self.fresh.best())
    }
}
