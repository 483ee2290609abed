#![allow(unsafe_code, reason = "functions of a shared object")]
//! The functions of the C ABI that the bench calls: of this program, or of the library as it ships.

use std::env;
use std::ffi::c_void;
use std::hint::black_box;

use libloading::Library;
use red_ffi::*;

use crate::not_run::NotRun;

/// Where the library lies that is to be loaded.
const PATH: &str = "RED_BENCH_LIBRARY";

/// Behind pointers wherever they come from: nothing of the library can be seen by the compiler.
macro_rules! functions {
    ($($field:ident: $name:ident($($argument:ty),*),)*) => {
        #[derive(Clone, Copy)]
        pub(super) struct Functions {
            $(pub(super) $field: extern "C" fn($($argument),*) -> red_status,)*
        }

        impl Functions {
            /// Those of this program.
            pub(super) fn linked() -> Self {
                Self { $($field: black_box($name as extern "C" fn($($argument),*) -> red_status),)* }
            }

            fn of(library: &'static Library) -> Result<Self, libloading::Error> {
                // SAFETY: the table of functions is compared with the header that this library is installed with.
                unsafe { Ok(Self { $($field: *library.get(stringify!($name))?,)* }) }
            }
        }
    };
}

functions! {
    preset: red_config_preset(u32, *mut red_config),
    open: red_scheduler_open_16x256x64(*mut c_void, usize, *const red_config, *mut red_scheduler),
    close: red_scheduler_close(*mut red_scheduler),
    dag_open: red_dag_open_16x256x64(*mut c_void, usize, *mut red_dag),
    dag_close: red_dag_close(*mut red_dag),
    add_node: red_dag_add_node(*mut red_dag, *const red_node, *mut u32),
    add_edge: red_dag_add_edge(*mut red_dag, u32, u32),
    add_task: red_scheduler_add_task(*mut red_scheduler, *const red_dag, *const red_timing, *mut u32),
    release: red_scheduler_release(*mut red_scheduler, u32, u64, *mut u32),
    poll: red_scheduler_poll(*mut red_scheduler, u64, *mut red_action),
    complete_and_poll: red_scheduler_complete_and_poll(*mut red_scheduler, u64, u64, *mut red_action),
}

impl Functions {
    /// Those of the shared library that the environment names.
    pub(super) fn loaded() -> Result<Self, NotRun> {
        let by_xtask = "run it by cargo xtask bench, which builds the library";
        let path = env::var_os(PATH).ok_or(NotRun::Unpackaged(by_xtask))?;
        // SAFETY: nothing runs when it is loaded.
        let library = unsafe { Library::new(&path) };
        // It stays as long as the program: functions are called to its end.
        let of = |library| Self::of(Box::leak(Box::new(library)));
        library.and_then(of).map_err(|reason| NotRun::Failed(reason.to_string()))
    }
}
