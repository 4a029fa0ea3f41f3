use std::str::FromStr;

use url::{Host as Named, Url};

/// Characters of an address at most.
const LONGEST: usize = 2000;

/// The port of an address that names none.
const PORT: u16 = 443;

/// A host that may be called, and at which port.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Host {
    name: String,
    port: u16,
}

impl FromStr for Host {
    type Err = String;

    /// A name, or a name and a port: `hooks.example`, `hooks.example:8443`.
    fn from_str(text: &str) -> Result<Host, String> {
        let wanted = || "a host's name is wanted, such as hooks.example or hooks.example:8443".to_owned();
        let url = Url::parse(&format!("https://{text}")).map_err(|_| wanted())?;
        let plain =
            url.path() == "/" && url.query().is_none() && url.fragment().is_none() && !text.contains(['/', '@', '*']);
        match url.host() {
            Some(Named::Domain(name)) if plain => {
                Ok(Host { name: name.to_owned(), port: url.port_or_known_default().unwrap_or(PORT) })
            }
            _ => Err(wanted()),
        }
    }
}

/// The hosts that may be called; none unless they are named.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Hosts {
    allowed: Vec<Host>,
    /// Whether addresses may be without TLS, which is for tests alone.
    #[cfg(test)]
    plain: bool,
}

impl From<Vec<Host>> for Hosts {
    fn from(allowed: Vec<Host>) -> Hosts {
        Hosts {
            allowed,
            #[cfg(test)]
            plain: false,
        }
    }
}

impl Hosts {
    pub fn is_empty(&self) -> bool {
        self.allowed.is_empty()
    }

    /// The address in this text.
    ///
    /// # Errors
    /// Why it may not be called.
    pub fn address(&self, text: &str) -> Result<Url, String> {
        if self.is_empty() {
            return Err("this server calls nobody: no host is allowed by --webhook-host".to_owned());
        }
        if text.len() > LONGEST {
            return Err(format!("the address has more than {LONGEST} characters"));
        }
        let url = Url::parse(text).map_err(|error| format!("not an address: {error}"))?;
        if url.scheme() != "https" && !self.may_be_plain() {
            return Err("the address has to begin with https://".to_owned());
        }
        if !url.username().is_empty() || url.password().is_some() || url.fragment().is_some() {
            return Err("the address is to have neither a user, a password nor a fragment".to_owned());
        }
        let (host, port) = (url.host(), url.port_or_known_default());
        let allowed = |allowed: &Host| host == Some(Named::Domain(&allowed.name)) && port == Some(allowed.port);
        if self.allowed.iter().any(allowed) {
            Ok(url)
        } else {
            Err("its host is none of those that this server calls".to_owned())
        }
    }

    /// The same hosts, also without TLS.
    #[cfg(test)]
    pub(super) fn without_tls(self) -> Hosts {
        Hosts { plain: true, ..self }
    }

    #[cfg(not(test))]
    fn may_be_plain(&self) -> bool {
        false
    }

    #[cfg(test)]
    fn may_be_plain(&self) -> bool {
        self.plain
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn only_hosts_that_are_named_are_called_and_by_tls() {
        let hosts: Hosts = ["hooks.example", "other.example:8443"].map(|host| host.parse().unwrap()).to_vec().into();
        for address in [
            "https://hooks.example/a?b=c",
            "https://HOOKS.example:443",
            "https://other.example:8443/",
            "https://hooks%2eexample/",
        ] {
            assert!(hosts.address(address).is_ok(), "{address}");
        }
        for (address, reason) in [
            ("http://hooks.example/", "https://"),
            ("ftp://hooks.example/", "https://"),
            ("https://other.example/", "none of those"),
            ("https://hooks.example:8443/", "none of those"),
            ("https://hooks.example.evil.org/", "none of those"),
            ("https://evil.org/hooks.example", "none of those"),
            ("https://hooks.example@evil.org/", "neither a user"),
            ("https://me:secret@hooks.example/", "neither a user"),
            ("https://hooks.example/#part", "neither a user"),
            ("https://127.0.0.1/", "none of those"),
            ("https://2130706433/", "none of those"),
            ("https://[::1]/", "none of those"),
            ("hooks.example", "not an address"),
            ("", "not an address"),
        ] {
            let refused = hosts.address(address).unwrap_err();
            assert!(refused.contains(reason), "{address}: {refused}");
        }
        let long = format!("https://hooks.example/{}", "a".repeat(2000));
        assert!(hosts.address(&long).unwrap_err().contains("2000"));
        assert!(Hosts::default().address("https://hooks.example/").unwrap_err().contains("--webhook-host"));
    }

    #[test]
    fn a_host_is_a_name_and_perhaps_a_port() {
        assert_eq!("Hooks.Example".parse(), Ok(Host { name: "hooks.example".to_owned(), port: 443 }));
        for text in ["", "*", "*.example/", "10.0.0.1", "[::1]", "a/b", "me@a", "https://a.example", "a:port"] {
            assert!(text.parse::<Host>().is_err(), "{text}");
        }
    }
}
