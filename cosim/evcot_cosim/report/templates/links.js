// SPDX-License-Identifier: Apache-2.0
// Links into the playback: #at=455123&see=hardware-14 is a time in microseconds and a track.

export function parseLink(hash) {
  const parts = new URLSearchParams(hash.replace(/^#/, ""));
  if (!parts.has("at")) return null;
  const at = Number(parts.get("at"));
  if (!Number.isFinite(at)) return null;
  const [, side, id] = /^([a-z0-9_]+)-(.*)$/s.exec(parts.get("see") ?? "") ?? [null, null, null];
  return { at, side, id };
}

/** Calls `go` for the link in the page's address, and for every link that is followed. */
export function followLinks(go) {
  const act = (hash) => {
    const link = parseLink(hash);
    if (link) go(link);
    return Boolean(link);
  };
  document.addEventListener("click", (event) => {
    const link = event.target.closest?.("a[href^='#at=']");
    if (!link || !act(link.getAttribute("href"))) return;
    event.preventDefault();
    history.replaceState(null, "", link.getAttribute("href"));
  });
  addEventListener("hashchange", () => act(location.hash));
  act(location.hash);
}
