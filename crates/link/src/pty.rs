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

/// A pseudo-terminal's end on which an emulated PLC sits.
pub struct Pty {
    own: File,
    /// The other end stays open, so that whoever comes and goes there does not end the line.
    _other: OwnedFd,
    path: PathBuf,
    /// A name by which the other end is found, however often the line is opened anew.
    link: Option<PathBuf>,
    /// How long a read waits.
    patience: Duration,
}

impl Pty {
    /// Opens one. With `link`, the other end has this name as well; a link of that name that is left over is replaced.
    ///
    /// # Errors
    /// The system gives none, or something else has that name.
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

    /// Where the other end is.
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
        // Where nobody reads, the line fills up: what is sent then is lost, as on wires.
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
        // One that was opened anew since has the name now.
        if std::fs::read_link(link).is_ok_and(|to| to == self.path) {
            let _ = std::fs::remove_file(link);
        }
    }
}
