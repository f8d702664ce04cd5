// For readers with a keyboard or a screen reader: the side columns have names, and what scrolls can be reached.
addEventListener("DOMContentLoaded", () => {
  document.querySelector("aside.sidebar-drawer")?.setAttribute("aria-label", "All pages");
  document.querySelector("aside.toc-drawer")?.setAttribute("aria-label", "On this page");
  for (const caption of document.querySelectorAll("p.caption[role=heading]")) caption.ariaLevel = "2";
  for (const box of document.querySelectorAll("pre, .table-wrapper, div.equation")) box.tabIndex = 0;
});
