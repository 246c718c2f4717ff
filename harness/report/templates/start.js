{
  let kept = null;
  try { kept = localStorage.getItem("theme"); } catch { /* a page of its own may not remember */ }
  const dark = matchMedia("(prefers-color-scheme: dark)").matches;
  document.documentElement.dataset.theme = kept ?? (dark ? "dark" : "light");
}
