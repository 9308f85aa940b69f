// Appended to a copy of a page by page_in_browser_test.sh: sorts its tables and writes into
// <body data-used> what is not as it should be, or "well".
"use strict";
{
  const wrong = [];
  const expect = (holds, what) => { if (!holds) wrong.push(what); };
  for (const table of document.querySelectorAll("table.sortable")) {
    const before = table.tBodies[0].rows.length;
    [...table.tHead.rows[0].cells].forEach((header, column) => {
      for (const direction of [1, -1]) {
        header.querySelector("button").click();
        const values = [...table.tBodies[0].rows].map((row) => row.cells[column].dataset.value);
        const numbers = values.filter((value) => value !== undefined).map(Number);
        expect(numbers.every((value, at) => at === 0 || direction * (value - numbers[at - 1]) >= 0), "a column is not sorted");
        if (header.classList.contains("number"))
          expect(!values.slice(0, numbers.length).includes(undefined), "missing numbers are not last");
      }
      expect(header.getAttribute("aria-sort") === "descending", "a heading does not say its order");
    });
    expect(table.tBodies[0].rows.length === before, "sorting lost rows");
  }
  document.body.dataset.used = wrong.length ? wrong[0] : "well";
}
