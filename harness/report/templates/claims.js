// Claims: by verdict, and by any words they contain.
if ($("claims-verdict")) {
  const claims = [...document.querySelectorAll(".claims li")];
  const filter = () => {
    const words = $("claims-search").value.toLowerCase().split(/\s+/);
    const verdict = $("claims-verdict").value;
    for (const claim of claims) {
      const text = claim.textContent.toLowerCase();
      claim.hidden = !(!verdict || claim.dataset.kind === verdict) || !words.every((w) => text.includes(w));
    }
    const left = claims.filter((claim) => !claim.hidden).length;
    $("claims-count").textContent = `${left} of ${claims.length} claims`;
  };
  for (const id of ["claims-verdict", "claims-search"]) $(id).addEventListener("input", filter);
  filter();
}
