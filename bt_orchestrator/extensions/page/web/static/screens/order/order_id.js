/** Ids of new orders: made here, so that an order that is sent twice is queued once. */

/** Make one of date, time and two random characters: WO-1122-0941-K7. */
export function newOrderId(moment = new Date()) {
  const two = (value) => String(value).padStart(2, '0');
  const day = two(moment.getMonth() + 1) + two(moment.getDate());
  const time = two(moment.getHours()) + two(moment.getMinutes());
  return `WO-${day}-${time}-${randomWord(2)}`;
}

/** Letters and digits that nobody takes for another. */
function randomWord(length) {
  const letters = 'ABCDEFGHJKLMNPQRSTUVWXYZ23456789';
  const bytes = crypto.getRandomValues(new Uint8Array(length));
  return [...bytes].map((byte) => letters[byte % letters.length]).join('');
}
