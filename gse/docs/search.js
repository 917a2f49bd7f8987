// SPDX-License-Identifier: Apache-2.0
// Search words in searchIndex, which gse/docs/search.py generates. ECMAScript 5 without a library.

function searchWords(text) {
  return text.toLowerCase().match(/[a-z0-9]+/g) || [];
}

// Find the sections that contain all words of the query, best first. A word of the query matches each
// word that begins with it: this scores 1, a match in a title 4 more, a match of the whole word 2 more.
function searchFind(index, query) {
  var wanted = searchWords(query),
    scores = {},
    i;
  for (i = 0; i < wanted.length; i += 1) {
    scores = searchScore(index, wanted[i], i === 0 ? null : scores);
  }
  return Object.keys(scores)
    .sort(function (a, b) {
      return scores[b] - scores[a] || a - b;
    })
    .map(function (number) {
      var section = index.sections[number],
        page = index.pages[section[0]];
      return {
        address: page[0] + (section[1] ? "#" + section[1] : ""),
        page: page[1],
        title: section[2] || page[1],
        excerpt: section[3]
      };
    });
}

// Compute the scores of the sections that also contain the next word. `before` contains the scores for the
// previous words; null for the first word.
function searchScore(index, wanted, before) {
  var best = {},
    scores = {};
  Object.keys(index.words).forEach(function (word) {
    if (word.indexOf(wanted) === 0) {
      index.words[word].forEach(function (number) {
        var whole = word === wanted ? 2 : 0;
        var title = searchWords(index.sections[number][2]).indexOf(word) >= 0 ? 4 : 0;
        best[number] = Math.max(best[number] || 0, 1 + whole + title);
      });
    }
  });
  Object.keys(best).forEach(function (number) {
    if (before === null || before[number]) {
      scores[number] = (before === null ? 0 : before[number]) + best[number];
    }
  });
  return scores;
}

// Show the query and the sections that it finds.
function searchShow(query) {
  var results = document.getElementById("results");
  var found = searchFind(searchIndex, query);
  function add(parent, tag, text) {
    var element = document.createElement(tag);
    element.textContent = text; // Not innerHTML: a link may bring a query with HTML in its address.
    parent.appendChild(element);
    return element;
  }
  document.getElementById("q").value = query;
  add(
    results,
    "p",
    found.length +
      (found.length === 1 ? " section" : " sections") +
      " found" +
      (found.length > 100 ? ", the first 100:" : "")
  );
  found.slice(0, 100).forEach(function (section) {
    var line = add(results, "p", "");
    add(line, "a", section.title).href = section.address;
    add(line, "span", " " + section.page).className = "chip";
    add(line, "br", "");
    add(line, "span", section.excerpt);
  });
}

if (typeof document !== "undefined") {
  (function () {
    var asked = /[?&]q=([^&]*)/.exec(window.location.search);
    if (asked && asked[1]) {
      searchShow(decodeURIComponent(asked[1].replace(/\+/g, " ")));
    }
  })();
}
