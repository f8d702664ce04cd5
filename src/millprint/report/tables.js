/* Tables that sort by a click on a column's name, and show only the rows that hold a text. */

for (const table of document.querySelectorAll("table.sorts")) {
  const body = table.tBodies[0];
  const heads = [...table.tHead.rows[0].cells];
  heads.forEach((head, column) => {
    head.querySelector("button").addEventListener("click", () => {
      const falls = head.getAttribute("aria-sort") === "ascending";
      heads.forEach((other) => other.removeAttribute("aria-sort"));
      head.setAttribute("aria-sort", falls ? "descending" : "ascending");
      const value = (row) => row.cells[column].dataset.value ?? row.cells[column].textContent;
      const number = (row) => (value(row).trim() === "" ? NaN : Number(value(row)));
      const rows = [...body.rows].sort((one, other) => {
        const [a, b] = [number(one), number(other)];
        // Numbers before words, empty cells last whichever way.
        const blank = (value(one).trim() === "") - (value(other).trim() === "");
        if (blank) return blank;
        const order = Number.isNaN(a) && Number.isNaN(b) ? value(one).localeCompare(value(other)) : Number.isNaN(a) - Number.isNaN(b) || a - b;
        return falls ? -order : order;
      });
      body.append(...rows);
    });
  });
  const search = document.querySelector(`input[data-table="${table.id}"]`);
  const count = document.querySelector(`output[for="${search?.id}"]`);
  search?.addEventListener("input", () => {
    const words = search.value.toLowerCase().split(/\s+/).filter(Boolean);
    let shown = 0;
    for (const row of body.rows) {
      const text = row.textContent.toLowerCase();
      row.hidden = !words.every((word) => text.includes(word));
      shown += !row.hidden;
    }
    count.textContent = `${shown} of ${body.rows.length} rows`;
  });
}
