// Claims: by verdict, and by any words they contain.
if ($("claims-verdict")) {
  const groups = [...document.querySelectorAll("details.claims")];
  const claims = groups.flatMap((group) => [...group.querySelectorAll("li")]);
  const filter = () => {
    const words = $("claims-search").value.toLowerCase().split(/\s+/).filter(Boolean);
    const verdict = $("claims-verdict").value;
    for (const group of groups) {
      const own = [...group.querySelectorAll("li")];
      for (const claim of own) {
        const text = claim.textContent.toLowerCase();
        claim.hidden = !(!verdict || group.dataset.kind === verdict) || !words.every((w) => text.includes(w));
      }
      const left = own.filter((claim) => !claim.hidden).length;
      group.hidden = !left;
      if (left && (words.length || verdict)) group.open = true;
    }
    const left = claims.filter((claim) => !claim.hidden).length;
    $("claims-count").textContent = `${left} of ${claims.length} claims`;
  };
  for (const id of ["claims-verdict", "claims-search"]) $(id).addEventListener("input", filter);
  filter();
}
