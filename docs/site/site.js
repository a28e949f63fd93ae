// Wide tables, the menu of small screens, and search without a server: `searchIndex` lists every section of the site (search_index.py). A section is found if it holds
// all words; words in its title count more, and whole words more than beginnings.
(function () {
    "use strict";
    var input = document.getElementById("search"), list = document.getElementById("search-results");
    var most = 12;

    function score(section, words) {
        var title = section.title.toLowerCase(), text = section.text, sum = 0;
        for (var i = 0; i < words.length; i++) {
            var own = 0;
            if (title.indexOf(words[i]) >= 0) own += 20;
            var count = text.split(words[i]).length - 1;
            own += Math.min(count, 5) + (count && (" " + text + " ").indexOf(" " + words[i] + " ") >= 0 ? 3 : 0);
            if (!own) return 0;
            sum += own;
        }
        return sum;
    }

    function find(query) {
        var words = query.toLowerCase().split(/\s+/).filter(Boolean);
        if (!words.length) return [];
        return searchIndex
            .map(function (section) { return { section: section, score: score(section, words) }; })
            .filter(function (match) { return match.score > 0; })
            .sort(function (a, b) { return b.score - a.score; })
            .slice(0, most);
    }

    // wide tables scroll by themselves
    document.querySelectorAll(".rst-content table").forEach(function (table) {
        var frame = document.createElement("div");
        frame.className = "wide";
        frame.tabIndex = 0;
        frame.setAttribute("role", "region");
        frame.setAttribute("aria-label", "Table");
        table.parentNode.insertBefore(frame, table);
        frame.appendChild(table);
    });

    // code that is wider than the page scrolls by keyboard too
    document.querySelectorAll(".rst-content pre code").forEach(function (code) { code.tabIndex = 0; });

    // on a phone, the button shows and hides the contents
    document.querySelector("button[data-toggle=wy-nav-top]").addEventListener("click", function () {
        document.querySelectorAll("[data-toggle=wy-nav-shift]").forEach(function (part) { part.classList.toggle("shift"); });
    });

    input.addEventListener("input", function () {
        list.textContent = "";
        var matches = find(input.value);
        matches.forEach(function (match) {
            var link = document.createElement("a");
            link.href = base_url + "/" + match.section.address;
            link.textContent = match.section.title;
            list.appendChild(link);
        });
        if (input.value.trim() && !matches.length) list.textContent = "Nothing found";
    });
})();
