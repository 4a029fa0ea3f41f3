export default function Inside() {
  return <p>…</p>;
}
