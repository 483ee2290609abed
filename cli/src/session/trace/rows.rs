//! Rows for the jobs of a task: jobs that overlap need one each.

/// The row of each job, from 0. `spans` are the jobs' times from release to end, by release. A job takes the first
/// row that is free again, so there are as many rows as jobs were in flight at once.
pub(super) fn rows(spans: impl Iterator<Item = (u64, u64)>) -> Vec<usize> {
    let mut free_at: Vec<u64> = Vec::new();
    let mut place = |(start, end): (u64, u64)| {
        let row = free_at.iter().position(|free| *free <= start).unwrap_or(free_at.len());
        match free_at.get_mut(row) {
            Some(free) => *free = end,
            None => free_at.push(end),
        }
        row
    };
    spans.map(&mut place).collect()
}

#[cfg(test)]
mod tests;
