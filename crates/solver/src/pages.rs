//! Memory for large arrays, in huge pages where the system has them.
//!
//! A sweep over a map of a million cells reads five streams at once, each through hundreds of pages of 4 KiB, and waits
//! for the translation of addresses. Linux backs a range with pages of 2 MiB when asked to (`MADV_HUGEPAGE`, where
//! `transparent_hugepage` says `madvise` or `always`).

/// `len` times `value`. Zeros come fresh from the system, and cost nothing until touched.
pub(crate) fn filled<T: Copy>(value: T, len: usize) -> Vec<T> {
    let mut numbers = vec![value; len];
    prefer_huge(&mut numbers);
    numbers
}

/// Bytes of a huge page.
#[cfg(all(target_os = "linux", not(miri)))]
const HUGE_BYTES: usize = 2 << 20;

/// Asks for huge pages if the numbers fill at least one. The system may decline; no result depends on it.
#[cfg(all(target_os = "linux", not(miri)))]
fn prefer_huge<T: Copy>(numbers: &mut [T]) {
    let bytes = size_of_val(numbers);
    if bytes < HUGE_BYTES {
        return;
    }
    // Advice applies to whole pages. The partial ones at the ends are left out.
    let start = numbers.as_mut_ptr().cast::<u8>();
    let skipped = start.align_offset(rustix::param::page_size());
    let Some(rest) = bytes.checked_sub(skipped) else { return };
    let whole = rest - rest % rustix::param::page_size();
    // SAFETY: the range lies within `numbers`, and this advice changes how memory is backed, never what it holds.
    let advised =
        unsafe { rustix::mm::madvise(start.add(skipped).cast(), whole, rustix::mm::Advice::LinuxHugepage) };
    // A system without huge pages declines, and small pages serve as well.
    let _ = advised;
}

#[cfg(not(all(target_os = "linux", not(miri))))]
fn prefer_huge<T: Copy>(_: &mut [T]) {}

#[cfg(test)]
mod tests {
    use super::filled;

    #[test]
    fn every_number_is_there_whatever_the_length() {
        for len in [0, 1, 511, 512, 262_143, 262_144, 262_145, 300_000] {
            let numbers = filled(0.5_f64, len);
            assert_eq!(numbers.len(), len);
            assert!(numbers.iter().all(|number| *number == 0.5), "of {len} numbers");
        }
    }
}
