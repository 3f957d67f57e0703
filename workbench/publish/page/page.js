"use strict";
// What moves on a page of results: pictures that are hovered over and zoomed into, tables that sort and filter, the
// trajectory of a case, dark and light. Without this script, and on paper, pictures and tables stand as they are.
(() => {
  const root = document.documentElement;
  const make = (name, attributes = {}, ...children) => {
    const element = document.createElement(name);
    for (const [key, value] of Object.entries(attributes)) element.setAttribute(key, value);
    element.append(...children);
    return element;
  };

  // ---- dark and light

  const figures = [];  // Bokeh's, which are coloured anew
  const painted = new Map();  // of each what has a colour: the model, the name of the property, the colour on paper
  const ink = {
    light: {paper: "#ffffff", ink: "#1c2126", faint: "#5b6670", line: "#d5dade"},
    dark: {paper: "#1d2125", ink: "#e6e9ec", faint: "#a3adb6", line: "#3a4148"},
  };
  const colours = () => ink[root.dataset.theme === "dark" ? "dark" : "light"];

  function paint(figure) {
    const now = colours();
    figure.background_fill_color = figure.border_fill_color = now.paper;
    figure.outline_line_color = now.line;
    for (const axis of [...figure.below, ...figure.left]) {
      axis.axis_label_text_color = axis.major_label_text_color = now.faint;
      axis.axis_line_color = axis.major_tick_line_color = now.line;
      axis.minor_tick_line_color = null;
    }
    for (const grid of figure.center) if ("grid_line_color" in grid) grid.grid_line_color = now.line;
    for (const [model, key, colour] of painted.get(figure) || []) model[key] = shown(colour);
  }

  function setTheme(name) {
    root.dataset.theme = name;
    const button = document.getElementById("theme");
    button.textContent = name === "dark" ? "light" : "dark";
    button.setAttribute("aria-label", `${button.textContent} page`);
    figures.forEach(paint);
  }

  // ---- pictures

  const isBlack = (colour) => colour === "#000000";

  // A colour of paper on the page at hand: in the dark what is grey turns over, and what has a hue gets lighter.
  function shown(colour) {
    if (root.dataset.theme !== "dark") return colour;
    const parts = [1, 3, 5].map((place) => parseInt(colour.slice(place, place + 2), 16));
    const grey = Math.max(...parts) - Math.min(...parts) < 12;
    const turned = parts.map((part) => Math.round(grey ? 235 - 0.8 * part : part + 0.25 * (255 - part)));
    return `#${turned.map((part) => Math.min(Math.max(part, 0), 255).toString(16).padStart(2, "0")).join("")}`;
  }

  function floats(text) {
    const double = text.startsWith(":");
    const bytes = Uint8Array.from(atob(double ? text.slice(1) : text), (letter) => letter.charCodeAt(0));
    return double ? new Float64Array(bytes.buffer) : new Float32Array(bytes.buffer);
  }

  function swatch(entry) {
    const picture = document.createElementNS("http://www.w3.org/2000/svg", "svg");
    picture.setAttribute("width", "26");
    picture.setAttribute("height", "12");
    const add = (name, attributes) => {
      const part = document.createElementNS("http://www.w3.org/2000/svg", name);
      for (const [key, value] of Object.entries(attributes)) part.setAttribute(key, value);
      picture.append(part);
    };
    const colour = (value) => (isBlack(value) ? "currentColor" : value);
    if (entry.fill) {
      const filled = {fill: colour(entry.fill), "fill-opacity": entry.alpha, stroke: "#888888", "stroke-width": 0.5};
      const framed = {fill: "none", stroke: colour(entry.fill), "stroke-width": 2};
      add("rect", {x: 1, y: 1, width: 24, height: 10, ...(entry.hollow ? framed : filled)});
    }
    if (entry.line) {
      add("line", {
        x1: 0, y1: 6, x2: 26, y2: 6, stroke: colour(entry.line.color), "stroke-opacity": entry.line.alpha,
        "stroke-width": Math.min(entry.line.width, 4), "stroke-dasharray": entry.line.dash.join(" "),
      });
    }
    if (entry.marker) {
      const looks = {fill: entry.marker.fill ? colour(entry.marker.fill) : "none", stroke: colour(entry.marker.color)};
      const shape = SHAPES[entry.marker.kind] || SHAPES.circle;
      const turned = `translate(13 6) rotate(${(-entry.marker.angle * 180) / Math.PI})`;
      add("path", {d: shape, transform: turned, "stroke-width": 1.5, ...looks});
    }
    return picture;
  }

  const SHAPES = {
    circle: "M4,0A4,4 0 1 1 -4,0A4,4 0 1 1 4,0Z",
    square: "M-3.5,-3.5H3.5V3.5H-3.5Z",
    triangle: "M0,-4.5L4.5,3.5H-4.5Z",
    inverted_triangle: "M0,4.5L4.5,-3.5H-4.5Z",
    diamond: "M0,-5L5,0L0,5L-5,0Z",
    plus: "M-1.5,-4.5H1.5V-1.5H4.5V1.5H1.5V4.5H-1.5V1.5H-4.5V-1.5H-1.5Z",
    cross: "M-4,0H4M0,-4V4",
    x: "M-3.5,-3.5L3.5,3.5M-3.5,3.5L3.5,-3.5",
    star: "M0,-5L1.2,-1.6L4.8,-1.5L1.9,0.6L2.9,4L0,2L-2.9,4L-1.9,0.6L-4.8,-1.5L-1.2,-1.6Z",
    dash: "M-4.5,0H4.5",
  };

  function keys(entries, toggle) {
    const list = make("ul", {class: "keys"});
    for (const entry of entries) {
      const button = make("button", {type: "button", "aria-pressed": "true"}, swatch(entry), entry.label);
      if (entry.marks.length) {
        button.title = "show or hide";
        button.addEventListener("click", () => {
          const on = button.getAttribute("aria-pressed") !== "true";
          button.setAttribute("aria-pressed", String(on));
          toggle(entry.marks, on);
        });
      } else {
        button.disabled = true;
      }
      list.append(make("li", {}, button));
    }
    return list;
  }

  const SPACE = 7;  // of a label from its tick, in pixels

  function plain(figure, axis, spec) {
    const log = spec.scale === "log";
    if (spec.ticks.length) {
      axis.ticker = new Bokeh.FixedTicker({ticks: spec.ticks.map(([place]) => place), minor_ticks: []});
      axis.major_label_overrides = new Map(spec.ticks);
      if (axis === figure.below[0] && spec.ticks.some(([, label]) => label.length > SPACE)) axis.major_label_orientation = 0.6;
    } else if (log) {
      const [low, high] = [...spec.range].sort((a, b) => a - b);
      const decades = Math.log10(high / low);
      const mantissas = decades > 4.3 ? [1] : [1, 2, 5];
      axis.ticker = decades < 0.9 ? new Bokeh.BasicTicker() : new Bokeh.LogTicker({mantissas, num_minor_ticks: 0});
      axis.formatter = new Bokeh.BasicTickFormatter({power_limit_high: 6, power_limit_low: -5});
    }
    for (const grid of figure.center) if (grid.dimension === Number(axis === figure.left[0])) grid.ticker = axis.ticker;
    axis.axis_label = spec.label;
    axis.axis_label_text_font_style = "normal";
    axis.axis_label_text_font_size = "12px";
  }

  // A mark in a figure: what was made, and each of its colours noted for `paint`.
  function draw(figure, mark, named) {
    const note = (model, looks) => {
      const own = painted.get(figure) || [];
      for (const [key, colour] of Object.entries(looks)) if (colour) own.push([model, key, colour]);
      painted.set(figure, own);
      return model;
    };
    const add = (method, arrays, looks, tinted) => {
      const source = new Bokeh.ColumnDataSource({data: arrays});
      const fields = Object.keys(arrays).filter((name) => !name.startsWith("said"));
      const made = figure[method](...fields.map((field) => ({field})), {...looks, ...tinted, source});
      note(made.glyph, tinted);
      return made;
    };
    const spots = () => {
      const arrays = {x: floats(mark.x), y: floats(mark.y)};
      arrays.said_x = mark.said_x ? floats(mark.said_x) : arrays.x;
      arrays.said_y = mark.said_y ? floats(mark.said_y) : arrays.y;
      return arrays;
    };
    const hovered = (renderer) => {
      renderer.name = named.get(mark.id) || mark.label || " ";
      return renderer;
    };
    const filled = {fill_alpha: mark.alpha, line_color: null};
    switch (mark.kind) {
      case "line": {
        const looks = {line_alpha: mark.alpha, line_width: mark.width, line_dash: mark.dash};
        return [hovered(add("line", spots(), looks, {line_color: mark.color}))];
      }
      case "points": {
        const {kind, color, fill, size, angle} = mark.marker;
        const looks = {marker: kind, size, angle, ...(fill ? {} : {fill_color: null})};
        return [hovered(add("scatter", spots(), looks, {line_color: color, ...(fill ? {fill_color: fill} : {})}))];
      }
      case "area":
        return [add("patch", {x: floats(mark.x), y: floats(mark.y)}, filled, {fill_color: mark.color})];
      case "cells": {
        const arrays = {};
        for (const side of ["left", "right", "bottom", "top"]) arrays[side] = floats(mark[side]);
        const source = new Bokeh.ColumnDataSource({data: {...arrays, colors: mark.colors}});
        const sides = ["left", "right", "bottom", "top"].map((field) => ({field}));
        return [figure.quad(...sides, {source, fill_color: {field: "colors"}, line_color: "#888888", line_width: 0.5})];
      }
      case "box": {
        const {left, right, bottom, top} = mark;
        if ([left, right, bottom, top].includes(null)) {
          const sides = Object.fromEntries(Object.entries({left, right, bottom, top}).filter(([, side]) => side !== null));
          const band = new Bokeh.BoxAnnotation({...sides, ...filled, fill_color: mark.color, level: "underlay"});
          figure.add_layout(band);
          return [note(band, {fill_color: mark.color})];
        }
        const arrays = {left: [left], right: [right], bottom: [bottom], top: [top]};
        const looks = {fill_alpha: mark.alpha, ...(mark.color ? {} : {fill_color: null}), ...(mark.edge ? {} : {line_color: null})};
        const tinted = {...(mark.color ? {fill_color: mark.color} : {}), ...(mark.edge ? {line_color: mark.edge} : {})};
        return [add("quad", arrays, looks, tinted)];
      }
      case "span": {
        const looks = {line_alpha: mark.alpha, line_width: mark.width, line_dash: mark.dash, line_color: mark.color};
        const span = new Bokeh.Span({dimension: mark.along, location: mark.at, ...looks});
        figure.add_layout(span);
        return [note(span, {line_color: mark.color})];
      }
      case "words": {
        const looks = {
          text_font_size: `${mark.size}px`, text_align: mark.align, text_baseline: mark.baseline,
          x_offset: mark.offset[0], y_offset: -mark.offset[1],
        };
        return [add("text", {x: [mark.x], y: [mark.y], text: [mark.text]}, looks, {text_color: mark.color})];
      }
    }
    return [];
  }

  const CURVES = ["line", "points"];
  const heightOf = (spec) => Math.max(spec.height, 190) + 55;

  // Ranges that move together: those of one list. (Bokeh shares a range within a document, and each panel is its own.)
  function joined(list, start, end) {
    const range = new Bokeh.Range1d(list.length ? {start: list[0].start, end: list[0].end} : {start, end});
    range.change.connect(() => {
      for (const other of list) if (other.start !== range.start || other.end !== range.end) other.setv({start: range.start, end: range.end});
    });
    list.push(range);
    return range;
  }

  function panel(spec, ranges, drawn, named) {
    const range = (axis, name) => joined((ranges[`${name}${axis.shared}`] ??= []), ...axis.range);
    const figure = Bokeh.Plotting.figure({
      height: heightOf(spec), min_width: 0, sizing_mode: "stretch_width",
      x_axis_type: spec.x.scale, y_axis_type: spec.y.scale, x_range: range(spec.x, "x"), y_range: range(spec.y, "y"),
      tools: "box_zoom,pan,reset,save", toolbar_location: "above",
    });
    figure.toolbar.logo = null;
    figure.toolbar.autohide = true;
    plain(figure, figure.below[0], spec.x);
    plain(figure, figure.left[0], spec.y);
    const curves = [];
    for (const mark of spec.marks) {
      const made = draw(figure, mark, named);
      if (CURVES.includes(mark.kind)) curves.push(...made);
      drawn.set(mark.id, [...(drawn.get(mark.id) || []), ...made]);
    }
    if (curves.length) {
      const said = (axis, name) => [axis.label || name, `@said_${name}{%.5g}`];
      figure.add_tools(new Bokeh.HoverTool({
        renderers: curves, tooltips: [["", "$name"], said(spec.x, "x"), said(spec.y, "y")],
        formatters: {"@said_x": "printf", "@said_y": "printf"}, line_policy: "nearest", attachment: "horizontal",
      }));
    }
    figures.push(figure);
    paint(figure);
    return figure;
  }

  const waiting = new WeakMap();
  const near = new IntersectionObserver((entries) => {
    for (const {target} of entries.filter((entry) => entry.isIntersecting)) {
      near.unobserve(target);
      waiting.get(target)();
    }
  }, {rootMargin: "300px"});

  function whenNear(element, act) {
    waiting.set(element, act);
    near.observe(element);
  }

  // A picture in place of its image: panels in a grid, each under its title and its keys, drawn when one comes near.
  function enliven(picture) {
    const spec = JSON.parse(picture.querySelector("script[type='application/json']").textContent);
    const live = make("div", {class: "live"});
    live.style.maxWidth = `${spec.width}px`;
    const columns = Math.max(...spec.panels.map((each) => each.place[2]));
    const grid = make("div", {class: "panels"});
    grid.style.gridTemplateColumns = `repeat(${columns}, minmax(0, 1fr))`;
    const [drawn, ranges, hidden, named] = [new Map(), {}, new Set(), new Map()];
    const toggle = (marks, on) => {
      for (const id of marks) {
        if (on) hidden.delete(id);
        else hidden.add(id);
        (drawn.get(id) || []).forEach((each) => (each.visible = on));
      }
    };
    for (const entry of [...spec.legend, ...spec.panels.flatMap((each) => each.legend)]) {
      entry.marks.forEach((id) => named.set(id, entry.label.replaceAll("\n", " ")));
    }
    if (spec.title) live.append(make("div", {class: "title"}, spec.title));
    if (spec.legend.length) live.append(keys(spec.legend, toggle));
    live.append(grid);
    for (const each of spec.panels) {
      const place = make("div", {class: "panel"});
      place.style.gridColumn = `${each.place[0] + 1} / ${each.place[1] + 1}`;
      if (each.title) place.append(make("div", {class: "words"}, each.title));
      if (each.legend.length) place.append(keys(each.legend, toggle));
      if (each.marks.length) {
        const plot = make("div", {class: "plot"});
        plot.style.minHeight = `${heightOf(each)}px`;
        place.append(plot);
        whenNear(plot, () => {
          Bokeh.Plotting.show(panel(each, ranges, drawn, named), plot);
          toggle([...hidden], false);
        });
      }
      for (const line of each.notes) place.append(make("p", {class: "said"}, line));
      grid.append(place);
    }
    picture.classList.add("live-shown");
    picture.insertBefore(live, picture.querySelector("figcaption"));
  }

  function watchPictures() {
    for (const picture of document.querySelectorAll(".picture")) {
      if (picture.querySelector("script[type='application/json']")) whenNear(picture, () => enliven(picture));
    }
  }

  // ---- tables

  const number = (text) => {
    const found = /^[<>≤≥±x\s]*([-+]?\d[\d.]*(?:e[-+]?\d+)?)/i.exec(text);
    return found ? parseFloat(found[1]) : NaN;
  };
  const valueOf = (cell) => {
    const text = (cell?.dataset.value ?? cell?.textContent ?? "").trim();
    return [number(text), text.toLowerCase()];
  };

  function compare(one, other) {
    const [[a, s], [b, t]] = [one, other];
    if (s === "" || t === "") return (s === "") - (t === "");  // what is empty comes last
    if (!Number.isNaN(a) && !Number.isNaN(b) && a !== b) return a - b;
    if (Number.isNaN(a) !== Number.isNaN(b)) return Number.isNaN(a) - Number.isNaN(b);
    return s.localeCompare(t);
  }

  function makeSort(table) {
    const heads = [...table.tHead.rows[0].cells];
    heads.forEach((head, column) => {
      const button = make("button", {type: "button", title: "sort"}, ...head.childNodes);
      head.replaceChildren(button);
      button.addEventListener("click", () => {
        const down = head.getAttribute("aria-sort") === "ascending";
        heads.forEach((each) => each.removeAttribute("aria-sort"));
        head.setAttribute("aria-sort", down ? "descending" : "ascending");
        const body = table.tBodies[0];
        const rows = [...body.rows].map((row) => [valueOf(row.cells[column]), row]);
        const filled = ([[, text]]) => text !== "";
        rows.sort(([a], [b]) => (down && a[1] !== "" && b[1] !== "" ? compare(b, a) : compare(a, b)));
        body.append(...rows.map(([, row]) => row));
      });
    });
  }

  // "rpm=120 pid rms error < 0.1": words that a row holds, and bounds of columns by their heading, or a part of it.
  function conditions(text, heads) {
    const plainHeads = heads.map((head) => head.replace(/\s*\(.*\)$/, ""));
    const columnOf = (name) => {
      const wanted = name.replaceAll("_", " ").replace(/\s*\(.*\)$/, "");
      const tests = [
        (head) => head === wanted || head === name,
        (head) => head.startsWith(wanted),
        (head) => head.split(/[ .]/).includes(wanted) || head.endsWith(`.${name}`),
      ];
      for (const test of tests) {
        const found = plainHeads.findIndex(test);
        if (found >= 0) return found;
      }
      return -1;
    };
    const tests = [];
    const unknown = [];
    let words = [];
    const parts = text.toLowerCase().replace(/\s*(<=|>=|!=|<|>|=)\s*/g, " $1 ").split(/\s+/).filter(Boolean);
    for (let i = 0; i < parts.length; i++) {
      if (!/^(<=|>=|!=|<|>|=)$/.test(parts[i])) {
        words.push(parts[i]);
        continue;
      }
      let column = -1;
      let name = "";
      for (let length = Math.min(words.length, 4); length > 0 && column < 0; length--) {  // the longest heading before the sign
        name = words.slice(-length).join(" ");
        column = columnOf(name);
        if (column >= 0) words = words.slice(0, -length);
      }
      const [sign, wanted] = [parts[i], parts[++i] ?? ""];
      if (column < 0) {
        unknown.push(name || sign);
        words = words.slice(0, -1);
        continue;
      }
      const limit = Number(wanted);
      tests.push((row) => {
        const [value, said] = valueOf(row.cells[column]);
        if (wanted === "") return true;
        if (sign === "=" || sign === "!=") {
          const alike = Number.isNaN(limit) ? said.startsWith(wanted) : value === limit && !Number.isNaN(Number(said.replace(/^<\s*/, "")));
          return alike === (sign === "=");
        }
        return {"<": value < limit, ">": value > limit, "<=": value <= limit, ">=": value >= limit}[sign];
      });
    }
    for (const word of words) tests.push((row) => row.textContent.toLowerCase().includes(word));
    return {tests, unknown};
  }

  function makeFilter(table) {
    const heads = [...table.tHead.rows[0].cells].map((head) => head.textContent.trim().toLowerCase());
    const rows = [...table.tBodies[0].rows];
    const bounded = heads.find((head, column) => !Number.isNaN(valueOf(rows[0].cells[column])[0])) || heads[0];
    const example = `words, or bounds: ${bounded.replace(/\s*\(.*\)$/, "")} > 1`;
    const field = make("input", {type: "search", placeholder: example, "aria-label": "filter"});
    const all = make("button", {type: "button", class: "all"}, "all");
    const count = make("span", {"aria-live": "polite"});
    const choices = [...(table.dataset.choices || "").split(",")].filter(Boolean).map(Number);
    const selects = choices.map((column) => {
      const values = [...new Set(rows.map((row) => row.cells[column].textContent.trim()))];
      const select = make("select", {"aria-label": heads[column]}, make("option", {value: ""}, `any ${heads[column]}`));
      values.forEach((value) => select.append(make("option", {value}, value || "none")));
      return [column, select, new Set(values)];
    });
    const apply = () => {
      const {tests, unknown} = conditions(field.value, heads);
      let left = 0;
      for (const row of rows) {
        const fits = tests.every((test) => test(row)) &&
          selects.every(([column, select]) => !select.selectedIndex || row.cells[column].textContent.trim() === select.value);
        row.hidden = !fits;
        left += fits;
      }
      const counted = left === rows.length ? `${rows.length} rows` : `${left} of ${rows.length} rows`;
      count.textContent = unknown.length ? `${counted}; no column "${unknown.join('", "')}"` : counted;
      all.hidden = left === rows.length;
    };
    const bar = make("div", {class: "filter", role: "search"}, field, ...selects.map(([, select]) => select), count, all);
    all.addEventListener("click", () => table.narrow({}));
    table.parentElement.before(bar);
    field.addEventListener("input", apply);
    selects.forEach(([, select]) => select.addEventListener("change", apply));
    table.narrow = (wanted) => {  // from elsewhere on the page: by column
      field.value = "";
      for (const [column, select, values] of selects) {
        const value = wanted[heads[column]];
        select.value = value !== undefined && values.has(value) ? value : "";
      }
      apply();
      if (Object.keys(wanted).length) (table.closest("section") || bar).scrollIntoView({block: "start"});
    };
    apply();
  }

  const LONG = 12;  // rows, from which a table can be filtered

  // ---- the trajectory of a case

  function shorts(text) {
    const {channels, values, units} = JSON.parse(text);
    const bytes = Uint8Array.from(atob(values), (letter) => letter.charCodeAt(0));
    const levels = new Uint16Array(bytes.buffer);
    const names = Object.keys(channels);
    const size = levels.length / names.length;
    const signals = Object.fromEntries(names.map((name, i) => {
      const [low, step] = channels[name];
      return [name, Float64Array.from(levels.subarray(i * size, (i + 1) * size), (level) => low + step * level)];
    }));
    return {signals, units};
  }

  const BEFORE = "#8a8f94";  // the case that was shown before

  function makeTrajectories(section) {
    const table = section.querySelector("table");
    const {views, names} = JSON.parse(section.querySelector("script.views").textContent);
    const [holder, title] = [section.querySelector(".trajectory"), section.querySelector(".trajectory-title")];
    let scopes = null;
    let last = null;

    const build = async () => {
      const grid = make("div", {class: "panels"});
      holder.replaceChildren(grid);
      const times = [];
      scopes = views.map((view) => {
        const figure = Bokeh.Plotting.figure({
          height: 240, min_width: 0, sizing_mode: "stretch_width", tools: "box_zoom,pan,reset,save",
          toolbar_location: "above", x_range: view.x === "time" ? joined(times, 0, 1) : joined([], 0, 1), y_range: joined([], 0, 1),
        });
        figure.toolbar.logo = null;
        figure.toolbar.autohide = true;
        figure.below[0].axis_label = view.x_label;
        figure.left[0].axis_label = view.y_label;
        for (const axis of [figure.below[0], figure.left[0]]) axis.axis_label_text_font_style = "normal";
        const curves = view.curves.flatMap((curve, i) => [true, false].map((before) => {
          const source = new Bokeh.ColumnDataSource({data: {x: [], y: []}});
          const looks = before ? {line_width: 1.2, line_dash: [5, 4]} : {line_width: 1.6};
          const color = before ? BEFORE : view.colours[i];
          const renderer = figure.line({field: "x"}, {field: "y"}, {source, line_color: color, ...looks});
          renderer.name = `${curve.name}${before ? ", before" : ""}`;
          painted.set(figure, [...(painted.get(figure) || []), [renderer.glyph, "line_color", color]]);
          return {...curve, before, source, renderer};
        }));
        figure.add_tools(new Bokeh.HoverTool({
          renderers: curves.map((curve) => curve.renderer), tooltips: [["", "$name"], ["", "(@x{%.5g}, @y{%.5g})"]],
          formatters: {"@x": "printf", "@y": "printf"},
        }));
        figures.push(figure);
        paint(figure);
        const place = make("div", {class: "panel"});
        const plot = make("div", {class: "plot"});
        place.append(make("div", {class: "words"}, view.title));
        const entry = (label, color, dash) => ({label, marks: [], line: {color, alpha: 1, width: 2, dash}});
        const entries = view.curves.map((curve, i) => entry(curve.name, view.colours[i], []));
        place.append(keys([...entries, entry("the line before", BEFORE, [5, 4])], () => {}), plot);
        grid.append(place);
        Bokeh.Plotting.show(figure, plot);
        return {view, curves, figure};
      });
    };

    const fill = (signals, before) => {
      for (const {view, curves} of scopes) {
        for (const curve of curves.filter((each) => each.before === before)) {
          const [x, y] = [signals?.[view.x], signals?.[curve.signal]];
          curve.source.data = x && y
            ? {x: x.map((value) => value * view.x_factor), y: y.map((value) => value * view.y_factor)}
            : {x: [], y: []};
        }
      }
    };

    const show = async (row) => {
      const stored = section.querySelector(`script[data-case="${row.dataset.case}"]`);
      if (!stored) return;
      if (scopes === null) await build();
      const {signals, units} = shorts(stored.textContent);
      if ("reference_position" in signals && "error" in signals) {
        signals.position = signals.reference_position.map((value, i) => value - signals.error[i]);
      }
      const said = names.map((column) => {
        const [head, text] = [table.tHead.rows[0].cells[column].textContent.trim(), row.cells[column].textContent.trim()];
        return /^[-+\d.]/.test(text) ? `${head} ${text}` : text;
      });
      const label = [...new Set(said.filter(Boolean))].join(", ");
      fill(last && last.row !== row ? last.signals : null, true);
      fill(signals, false);
      for (const {view, curves, figure} of scopes) {
        figure.left[0].axis_label = view.y_label in units ? `${view.y_label} (${units[view.y_label]})` : view.y_label;
        const reach = (axis, margin) => {
          const values = curves.flatMap((curve) => [...curve.source.data[axis]]);
          const [low, high] = [Math.min(...values), Math.max(...values)];
          const room = margin * (high - low || Math.abs(high) || 1);
          if (values.length) figure[`${axis}_range`].setv({start: low - room, end: high + room});
        };
        reach("x", view.x === "time" ? 0 : 0.05);
        reach("y", 0.06);
      }
      const before = last && last.row !== row ? ` (in grey: ${last.label})` : "";
      title.textContent = `${label}${before}`;
      table.querySelectorAll("tr[aria-selected]").forEach((each) => each.removeAttribute("aria-selected"));
      row.setAttribute("aria-selected", "true");
      last = {row, signals, label};
    };

    const hold = (row) => {  // the line that the keyboard goes on from
      table.querySelectorAll("tr[tabindex]").forEach((each) => each.removeAttribute("tabindex"));
      row.tabIndex = 0;
      row.focus();
    };

    table.tBodies[0].addEventListener("click", (event) => {
      const row = event.target.closest("tr");
      if (!row) return;
      hold(row);
      show(row);
    });
    table.tBodies[0].addEventListener("keydown", (event) => {
      const row = event.target.closest("tr");
      const next = {ArrowDown: "nextElementSibling", ArrowUp: "previousElementSibling"}[event.key];
      if (event.key === "Enter" || event.key === " ") show(row);
      else if (next) {
        let other = row[next];
        while (other && other.hidden) other = other[next];
        if (other) {
          hold(other);
          show(other);
        }
      } else return;
      event.preventDefault();
    });
    const first = table.tBodies[0].rows[0];
    if (first) first.tabIndex = 0;
    whenNear(title, () => {
      const row = [...table.tBodies[0].rows].find((each) => !each.hidden);
      if (row && last === null) show(row);
    });
  }

  // ---- begin

  // What a browser remembers of these pages, where it remembers anything of files.
  function kept(name, value) {
    try {
      if (value !== undefined) localStorage.setItem(name, value);
      return localStorage.getItem(name);
    } catch {
      return null;
    }
  }

  const wanted = window.matchMedia("(prefers-color-scheme: dark)");
  const button = document.getElementById("theme");
  button.hidden = false;
  button.addEventListener("click", () => {
    setTheme(root.dataset.theme === "dark" ? "light" : "dark");
    kept("theme", root.dataset.theme);
  });
  wanted.addEventListener("change", () => setTheme(wanted.matches ? "dark" : "light"));
  setTheme(kept("theme") || (wanted.matches ? "dark" : "light"));
  document.querySelectorAll("table.sorts").forEach((table) => {
    makeSort(table);
    if (table.tBodies[0].rows.length > LONG) makeFilter(table);
  });
  if (window.Bokeh) {
    Bokeh.set_log_level("error");
    watchPictures();
    document.querySelectorAll("section.cases").forEach(makeTrajectories);
  }
  document.querySelectorAll("[data-narrow]").forEach((field) => {
    const table = document.querySelector("section.cases table");
    if (!table || !table.narrow) return;
    field.tabIndex = 0;
    field.setAttribute("role", "button");
    const go = () => table.narrow(JSON.parse(field.dataset.narrow));
    field.addEventListener("click", go);
    field.addEventListener("keydown", (event) => { if (event.key === "Enter") go(); });
  });
})();
