//! A pseudo-terminal: a serial line between two programs of one machine.

use rustix::event::{PollFd, PollFlags, Timespec, poll};
use rustix::fs::{Mode, OFlags};
use rustix::pty::{OpenptFlags, grantpt, openpt, ptsname, unlockpt};
use rustix::termios::{OptionalActions, tcgetattr, tcsetattr};
use std::fs::File;
use std::io::{self, ErrorKind, Read, Write};
use std::os::fd::OwnedFd;
use std::os::unix::fs::symlink;
use std::path::{Path, PathBuf};
use std::time::Duration;

/// The end of a pseudo-terminal that an emulated PLC uses.
pub struct Pty {
    own: File,
    /// The other end is kept open, so that the line does not end when a client disconnects.
    _other: OwnedFd,
    path: PathBuf,
    /// A fixed name of the other end, even if the line is opened again.
    link: Option<PathBuf>,
    /// How long a read waits.
    patience: Duration,
}

impl Pty {
    /// Opens a pseudo-terminal. With `link`, the other end also has this name; an existing link of this name is
    /// replaced.
    ///
    /// # Errors
    /// The system has no pseudo-terminal, or the name is used by something other than a link.
    pub fn open(link: Option<&Path>, patience: Duration) -> io::Result<Pty> {
        let own = openpt(OpenptFlags::RDWR | OpenptFlags::NOCTTY)?;
        grantpt(&own)?;
        unlockpt(&own)?;
        let name = ptsname(&own, Vec::new())?;
        let other = rustix::fs::open(&name, OFlags::RDWR | OFlags::NOCTTY, Mode::empty())?;
        let mut set = tcgetattr(&other)?;
        set.make_raw();
        tcsetattr(&other, OptionalActions::Now, &set)?;
        let name = name.into_string().map_err(|_| io::Error::from(ErrorKind::InvalidData))?;
        let path = PathBuf::from(name);
        if let Some(link) = link {
            if link.symlink_metadata().is_ok_and(|found| found.is_symlink()) {
                std::fs::remove_file(link)?;
            }
            symlink(&path, link)?;
        }
        Ok(Pty { own: own.into(), _other: other, path, link: link.map(Path::to_owned), patience })
    }

    /// The path of the other end.
    #[must_use]
    pub fn path(&self) -> &Path {
        self.link.as_deref().unwrap_or(&self.path)
    }
}

impl Read for Pty {
    fn read(&mut self, buffer: &mut [u8]) -> io::Result<usize> {
        let mut fds = [PollFd::new(&self.own, PollFlags::IN)];
        let patience = Timespec::try_from(self.patience).map_err(io::Error::other)?;
        match poll(&mut fds, Some(&patience))? {
            0 => Err(ErrorKind::TimedOut.into()),
            _ => self.own.read(buffer),
        }
    }
}

impl Write for Pty {
    fn write(&mut self, bytes: &[u8]) -> io::Result<usize> {
        // If nobody reads, the line fills up. Further bytes are lost, as on wires.
        let mut fds = [PollFd::new(&self.own, PollFlags::OUT)];
        match poll(&mut fds, Some(&Timespec::default()))? {
            0 => Ok(bytes.len()),
            _ => self.own.write(bytes),
        }
    }

    fn flush(&mut self) -> io::Result<()> {
        self.own.flush()
    }
}

impl Drop for Pty {
    fn drop(&mut self) {
        let Some(link) = &self.link else { return };
        // A pseudo-terminal that was opened later may have taken over the name.
        if std::fs::read_link(link).is_ok_and(|to| to == self.path) {
            let _ = std::fs::remove_file(link);
        }
    }
}
