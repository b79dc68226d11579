//! The command `biprism`, and what it owes the system that starts it: a sentence and exit code 2 where memory ends or a file
//! may grow no further, and word of a stdout that is closed.
#![allow(unsafe_code, reason = "the system's own calls: each does one thing, told beside it")]

use biprism::cli::{self, Started};
use std::alloc::{GlobalAlloc, Layout, System};
use std::process::ExitCode;
use std::sync::atomic::{AtomicBool, Ordering};

fn main() -> ExitCode {
    #[cfg(unix)]
    // SAFETY: SIG_IGN is a disposition that any signal of this kind may have; a write then fails with EFBIG.
    unsafe {
        libc::signal(libc::SIGXFSZ, libc::SIG_IGN);
    }
    keep_memory();
    let started = Started { stdout_is_open: STDOUT_IS_OPEN.load(Ordering::Relaxed) };
    ExitCode::from(cli::run(std::env::args_os().collect(), started))
}

/// Has the system keep what memory was given back, up to some of it, for what is asked for next: pictures come and go, and each page of a
/// new one costs a fault. Larger blocks are mapped apart, and given back at once.
#[cfg(all(target_os = "linux", target_env = "gnu"))]
fn keep_memory() {
    const LARGEST_KEPT: libc::c_int = 32 << 20;
    const MOST_KEPT: libc::c_int = 256 << 20;
    // SAFETY: settings of the allocator, before any other thread.
    unsafe {
        libc::mallopt(libc::M_MMAP_THRESHOLD, LARGEST_KEPT);
        libc::mallopt(libc::M_TRIM_THRESHOLD, MOST_KEPT);
    }
}

#[cfg(not(all(target_os = "linux", target_env = "gnu")))]
fn keep_memory() {}

/// Whether stdout was open before the standard library began, which opens /dev/null in place of a closed one.
static STDOUT_IS_OPEN: AtomicBool = AtomicBool::new(true);

#[cfg(target_os = "linux")]
extern "C" fn look_at_stdout() {
    // SAFETY: F_GETFD reads the flags of a descriptor, or fails where there is none.
    let open = unsafe { libc::fcntl(libc::STDOUT_FILENO, libc::F_GETFD) } != -1;
    STDOUT_IS_OPEN.store(open, Ordering::Relaxed);
}

/// Called before `main` by the system's loader.
#[cfg(target_os = "linux")]
#[used]
#[unsafe(link_section = ".init_array")]
static BEFORE_MAIN: extern "C" fn() = look_at_stdout;

/// The system's memory, with a sentence where it ends.
struct Memory;

#[global_allocator]
static MEMORY: Memory = Memory;

// SAFETY: every call is handed on to the system's allocator as it came; a null that it returns is never handed back.
unsafe impl GlobalAlloc for Memory {
    unsafe fn alloc(&self, layout: Layout) -> *mut u8 {
        some(unsafe { System.alloc(layout) }, layout.size())
    }

    unsafe fn alloc_zeroed(&self, layout: Layout) -> *mut u8 {
        some(unsafe { System.alloc_zeroed(layout) }, layout.size())
    }

    unsafe fn realloc(&self, pointer: *mut u8, layout: Layout, size: usize) -> *mut u8 {
        some(unsafe { System.realloc(pointer, layout, size) }, size)
    }

    unsafe fn dealloc(&self, pointer: *mut u8, layout: Layout) {
        unsafe { System.dealloc(pointer, layout) }
    }
}

/// The pointer, or the end of the program: files in the making have no name yet and are gone with it.
#[inline(always)]
fn some(pointer: *mut u8, bytes: usize) -> *mut u8 {
    if pointer.is_null() { out_of_memory(bytes) } else { pointer }
}

#[cold]
#[cfg(unix)]
fn out_of_memory(bytes: usize) -> ! {
    // Written without memory of its own.
    let mut text = [0u8; 256];
    let mut rest = &mut text[..];
    let _ = std::io::Write::write_fmt(
        &mut rest,
        format_args!(
            "error: memory has run out: {bytes} bytes more are not to be had\n  = help: free some, allow more (`ulimit \
             -v`), take fewer threads (--threads) or a smaller picture\n"
        ),
    );
    let left = rest.len();
    // SAFETY: the bytes written are those of `text`; `_exit` runs nothing of this program any more.
    unsafe {
        libc::write(libc::STDERR_FILENO, text.as_ptr().cast(), text.len() - left);
        libc::_exit(2)
    }
}

#[cold]
#[cfg(not(unix))]
fn out_of_memory(_: usize) -> ! {
    std::process::abort()
}
