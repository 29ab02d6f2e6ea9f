//! Unused devices that a calibration may write in addition to its own.

/// Unused devices, as the user names them.
#[derive(Debug, Clone, Default, PartialEq, Eq)]
pub struct Spare(Vec<String>);

impl Spare {
    /// Checks the devices: `Y1F0`, `L100`, `U4\\G100`.
    ///
    /// # Errors
    /// The first name that is not a device.
    pub fn new(devices: &[String]) -> Result<Spare, String> {
        let devices: Vec<String> =
            devices.iter().map(|device| device.trim().to_ascii_uppercase()).collect();
        let is_device = |device: &&String| {
            let letters = letters(device);
            let number = &device[letters.len()..];
            let digits = !number.is_empty() && number.chars().all(|one| one.is_ascii_hexdigit());
            buffer(device).is_some() || (!letters.is_empty() && digits)
        };
        match devices.iter().find(|device| !is_device(device)) {
            Some(device) => Err(device.clone()),
            None => Ok(Spare(devices)),
        }
    }

    /// The device with those letters.
    #[must_use]
    pub fn named(&self, letters_of: &str) -> Option<&str> {
        self.0.iter().map(String::as_str).find(|device| letters(device) == letters_of)
    }

    /// The buffer memory of a module.
    #[must_use]
    pub fn buffer(&self) -> Option<&str> {
        self.0.iter().map(String::as_str).find(|device| buffer(device).is_some())
    }

    /// A module's number and the first of 64 words of its buffer memory.
    #[must_use]
    pub fn module(&self) -> Option<(u32, u32)> {
        buffer(self.buffer()?)
    }

    /// All of them.
    #[must_use]
    pub fn devices(&self) -> &[String] {
        &self.0
    }
}

fn letters(device: &str) -> &str {
    let end = device.find(|one: char| !one.is_ascii_alphabetic()).unwrap_or(device.len());
    // A hexadecimal number may begin with a letter: these areas have one-letter names.
    let short = ["X", "Y", "B", "W"].iter().find(|one| device.starts_with(**one));
    short.map_or(&device[..end], |one| &device[..one.len()])
}

fn buffer(device: &str) -> Option<(u32, u32)> {
    let (unit, address) = device.strip_prefix('U')?.split_once("\\G")?;
    Some((u32::from_str_radix(unit, 16).ok()?, address.parse().ok()?))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn devices_are_found_by_their_letters() {
        let named = ["yAF", "ZR100", "u4\\g100", "B1F"].map(str::to_owned);
        let spare = Spare::new(&named).expect("devices");
        assert_eq!(spare.named("Y"), Some("YAF"));
        assert_eq!(spare.named("ZR"), Some("ZR100"));
        assert_eq!(spare.named("L"), None);
        assert_eq!((spare.buffer(), spare.module()), (Some("U4\\G100"), Some((4, 100))));
        for wrong in ["", "Y", "100", "U4G100", "D1-D2"] {
            assert_eq!(Spare::new(&[wrong.to_owned()]), Err(wrong.to_owned()));
        }
    }
}
