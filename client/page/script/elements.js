// Elements, colours and numbers as text.

const byId = id => document.getElementById(id);

const text = (value, digits = 4) => {
  if (value === null || value === undefined || Number.isNaN(value)) return '–';
  if (value === 0) return '0';
  const magnitude = Math.abs(value);
  const rounded = Number(value.toPrecision(digits));
  const written = magnitude >= 1e6 || magnitude < 1e-3 ? Number(value.toPrecision(3)).toExponential() : String(rounded);
  return written.replace('-', '−');
};
const words = name => name.toLowerCase().replace('_', ' ');
const colour = name => getComputedStyle(document.documentElement).getPropertyValue('--' + name).trim();
const runColour = run => colour('run-' + run.index % 10);
const make = (tag, attributes = {}, ...children) => {
  const element = document.createElement(tag);
  for (const [name, value] of Object.entries(attributes)) {
    if (name === 'text') element.textContent = value;
    else if (name === 'mark') element.style.setProperty('--mark', value);
    else element.setAttribute(name, value);
  }
  element.append(...children);
  return element;
};

const fitCanvas = (canvas, height) => {
  const ratio = window.devicePixelRatio || 1;
  const width = canvas.clientWidth;
  if (height) canvas.style.height = height + 'px';
  const tall = height || canvas.clientHeight;
  if (canvas.width !== Math.round(width * ratio) || canvas.height !== Math.round(tall * ratio)) {
    canvas.width = Math.round(width * ratio);
    canvas.height = Math.round(tall * ratio);
  }
  const pen = canvas.getContext('2d');
  pen.setTransform(ratio, 0, 0, ratio, 0, 0);
  pen.clearRect(0, 0, width, tall);
  return {pen, width, height: tall};
};
