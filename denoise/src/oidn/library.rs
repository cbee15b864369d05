//! Open Image Denoise, loaded from an installed library while the program runs: the one place of this workspace with
//! `unsafe` code.
//!
//! Why it is sound: (1) the signatures below are those of the C header of version 2, whose ABI its authors keep stable
//! within the major number; [`Library::open`] asks for the version and refuses any other. (2) The functions live as long as
//! the [`libloading::Library`] they came from, which is kept beside them and dropped last. (3) The library reads and writes
//! pixels only while `oidnExecuteFilter` runs; every slice lent to a filter outlives it inside [`Library::filter`], has the
//! length that width, height and format say (checked), and the output alone is written. (4) The device is the CPU's, so that
//! pointers of the host are valid to it. (5) Handles are released once, by the guards that made them. (6) `Library` is used
//! through `&self` from one thread at a time, as it is neither `Send` nor `Sync` (raw pointer).
#![allow(unsafe_code)]

use super::OidnError;
use libloading::Symbol;
use std::ffi::{CStr, OsString, c_char, c_int, c_void};

/// Names that installations have.
const NAMES: &[&str] = &[
    "libOpenImageDenoise.so.2",
    "libOpenImageDenoise.so",
    "libOpenImageDenoise.2.dylib",
    "libOpenImageDenoise.dylib",
    "OpenImageDenoise.dll",
];

const DEVICE_CPU: c_int = 1;
const FORMAT_FLOAT3: c_int = 3;
const MAJOR: c_int = 2;

type Handle = *mut c_void;

/// The functions that are used, as the header declares them.
struct Functions {
    commit_device: unsafe extern "C" fn(Handle),
    device_error: unsafe extern "C" fn(Handle, *mut *const c_char) -> c_int,
    release_device: unsafe extern "C" fn(Handle),
    new_filter: unsafe extern "C" fn(Handle, *const c_char) -> Handle,
    set_image:
        unsafe extern "C" fn(Handle, *const c_char, *mut c_void, c_int, usize, usize, usize, usize, usize),
    set_bool: unsafe extern "C" fn(Handle, *const c_char, bool),
    set_int: unsafe extern "C" fn(Handle, *const c_char, c_int),
    commit_filter: unsafe extern "C" fn(Handle),
    execute_filter: unsafe extern "C" fn(Handle),
    release_filter: unsafe extern "C" fn(Handle),
}

/// A library with a device of its.
pub struct Library {
    functions: Functions,
    device: Handle,
    // Dropped after `drop` released the device: fields go after the destructor's body.
    _library: libloading::Library,
}

/// A filter, released when it goes.
struct Filter<'a> {
    functions: &'a Functions,
    handle: Handle,
}

impl Drop for Filter<'_> {
    fn drop(&mut self) {
        // SAFETY: made by `new_filter`, released nowhere else (5).
        unsafe { (self.functions.release_filter)(self.handle) }
    }
}

impl Drop for Library {
    fn drop(&mut self) {
        // SAFETY: made in `open`, released nowhere else (5); every filter borrows `self` and is gone.
        unsafe { (self.functions.release_device)(self.device) }
    }
}

/// What a filter reads: three floats a pixel each, all of one size.
pub struct Images<'a> {
    /// Linear radiance.
    pub color: &'a [[f32; 3]],
    /// 0..1.
    pub albedo: &'a [[f32; 3]],
    /// Unit, any space.
    pub normal: &'a [[f32; 3]],
    /// Pixels.
    pub size: [u32; 2],
}

impl Library {
    /// Loads the library at `path`, or the first of its usual names that the system finds, and opens its CPU device.
    ///
    /// # Errors
    /// It is not there, is not version 2, lacks a function, or gives no device.
    pub fn open(path: Option<OsString>) -> Result<Self, OidnError> {
        let names: Vec<OsString> = match path {
            Some(path) => vec![path],
            None => NAMES.iter().map(OsString::from).collect(),
        };
        let mut said = String::new();
        for name in &names {
            // SAFETY: loading runs the library's initialisers; that the user's installation may be run is the user's word,
            // as for every program linked with it.
            match unsafe { libloading::Library::new(name) } {
                Ok(library) => return Self::with(library),
                Err(e) => said = e.to_string(),
            }
        }
        Err(OidnError::NotFound { message: said })
    }

    fn with(library: libloading::Library) -> Result<Self, OidnError> {
        fn get<T: Copy>(library: &libloading::Library, name: &str) -> Result<T, OidnError> {
            // SAFETY: T is the header's signature of this name (1); it is copied out and kept with the library (2).
            let found: Result<Symbol<'_, T>, _> = unsafe { library.get(name.as_bytes()) };
            found.map(|symbol| *symbol).map_err(|e| OidnError::NotFound { message: e.to_string() })
        }
        let new_device: unsafe extern "C" fn(c_int) -> Handle = get(&library, "oidnNewDevice")?;
        let device_int: unsafe extern "C" fn(Handle, *const c_char) -> c_int =
            get(&library, "oidnGetDeviceInt")?;
        let functions = Functions {
            commit_device: get(&library, "oidnCommitDevice")?,
            device_error: get(&library, "oidnGetDeviceError")?,
            release_device: get(&library, "oidnReleaseDevice")?,
            new_filter: get(&library, "oidnNewFilter")?,
            set_image: get(&library, "oidnSetSharedFilterImage")?,
            set_bool: get(&library, "oidnSetFilterBool")?,
            set_int: get(&library, "oidnSetFilterInt")?,
            commit_filter: get(&library, "oidnCommitFilter")?,
            execute_filter: get(&library, "oidnExecuteFilter")?,
            release_filter: get(&library, "oidnReleaseFilter")?,
        };
        // SAFETY: (1), (4).
        let device = unsafe { new_device(DEVICE_CPU) };
        if device.is_null() {
            return Err(OidnError::Refused { message: "it gives no CPU device".into() });
        }
        // From here on the device is released with `this`.
        let this = Self { functions, device, _library: library };
        // SAFETY: the device is live; the name ends in 0.
        let major = unsafe { device_int(this.device, c"versionMajor".as_ptr()) };
        if major != MAJOR {
            return Err(OidnError::Version { found: major, wanted: MAJOR });
        }
        // SAFETY: the device is live.
        unsafe { (this.functions.commit_device)(this.device) };
        this.check()?;
        Ok(this)
    }

    fn check(&self) -> Result<(), OidnError> {
        let mut message: *const c_char = std::ptr::null();
        // SAFETY: the device is live, `message` is written with null or a string that lives until the next call (header).
        let code = unsafe { (self.functions.device_error)(self.device, &mut message) };
        if code == 0 {
            return Ok(());
        }
        let message = match message.is_null() {
            true => format!("error {code}"),
            // SAFETY: not null, ends in 0, copied before the next call.
            false => unsafe { CStr::from_ptr(message) }.to_string_lossy().into_owned(),
        };
        Err(OidnError::Refused { message })
    }

    /// Filters high dynamic range light.
    ///
    /// # Errors
    /// Pictures of other lengths than the size says, or the library's own words.
    pub fn filter(
        &self,
        images: &Images<'_>,
        has_clean_guides: bool,
        quality: i32,
    ) -> Result<Vec<[f32; 3]>, OidnError> {
        let [width, height] = images.size.map(|n| n as usize);
        let mut output = vec![[0.0f32; 3]; width * height];
        for image in [images.color, images.albedo, images.normal] {
            if image.len() != output.len() {
                return Err(OidnError::Length { found: image.len(), wanted: output.len() });
            }
        }
        let f = &self.functions;
        // SAFETY: the device is live; the name ends in 0.
        let handle = unsafe { (f.new_filter)(self.device, c"RT".as_ptr()) };
        if handle.is_null() {
            self.check()?;
            return Err(OidnError::Refused { message: "it gives no filter".into() });
        }
        let filter = Filter { functions: f, handle };
        let set = |name: &CStr, pixels: *mut c_void| {
            // SAFETY: `pixels` is valid for width * height * 12 bytes (checked above) until `filter` is released at the end
            // of this function (3); strides of 0 mean densely packed, as slices of [f32; 3] are.
            unsafe {
                (f.set_image)(filter.handle, name.as_ptr(), pixels, FORMAT_FLOAT3, width, height, 0, 0, 0);
            }
        };
        // Inputs are only read (3).
        set(c"color", images.color.as_ptr().cast_mut().cast());
        set(c"albedo", images.albedo.as_ptr().cast_mut().cast());
        set(c"normal", images.normal.as_ptr().cast_mut().cast());
        set(c"output", output.as_mut_ptr().cast());
        // SAFETY: the filter is live, names end in 0, what it was lent is still there (3).
        unsafe {
            (f.set_bool)(filter.handle, c"hdr".as_ptr(), true);
            (f.set_bool)(filter.handle, c"cleanAux".as_ptr(), has_clean_guides);
            (f.set_int)(filter.handle, c"quality".as_ptr(), quality);
            (f.commit_filter)(filter.handle);
            (f.execute_filter)(filter.handle);
        }
        drop(filter);
        self.check()?;
        Ok(output)
    }
}
