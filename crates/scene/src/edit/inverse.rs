//! How an edit is undone: by edits.

use crate::{Configuration, Edit, Material, SceneError, format::ObjectEntry};

impl Edit {
    /// Edits that lead back to `before` when they follow this one in order: to an equal configuration, which is written to the same
    /// file. Not to the same numbers of slots ([`Configuration::object_slots`]).
    pub fn inverse(&self, before: &Configuration) -> Result<Vec<Edit>, SceneError> {
        let object = |name: &str| before.object_id(name).map(|id| before.object(id));
        let lamp = |name: &str| before.state().lamp_id(name).map(|id| before.lamp(id));
        let back = match self {
            Edit::Move { object: name, .. } | Edit::Drag { object: name, .. } => {
                Edit::Move { object: name.clone(), to: object(name)?.pose.position }
            }
            Edit::Turn { object: name, .. } => Edit::Turn { object: name.clone(), to: object(name)?.pose.rotation },
            Edit::Put { object: name, .. } => {
                let ObjectEntry { on, position, rotation, .. } = object(name)?.stated();
                Edit::Put { object: name.clone(), on, to: position, rotation }
            }
            Edit::Paint { object: name, .. } => {
                let back = Edit::Paint { object: name.clone(), material: object(name)?.entry.material.clone() };
                return self.and_forget(back, before);
            }
            Edit::Reflect { material, .. } => {
                Edit::Reflect { material: material.clone(), to: before.state().material(material)?.stated().reflectance }
            }
            Edit::Texture { material, .. } => {
                Edit::Texture { material: material.clone(), texture: before.state().material(material)?.texture_path.clone() }
            }
            Edit::AddMaterial { name, .. } => Edit::RemoveMaterial { material: name.clone() },
            Edit::RemoveMaterial { material } => return remade(material, before),
            Edit::Add(entry) => return self.and_forget(Edit::Remove { object: entry.name.clone() }, before),
            Edit::Duplicate { name, .. } => Edit::Remove { object: name.clone() },
            Edit::Remove { .. } => return self.added_again(before),
            Edit::MoveLamp { lamp: name, .. } => Edit::MoveLamp { lamp: name.clone(), to: lamp(name)?.pose.position },
            Edit::TurnLamp { lamp: name, .. } => Edit::TurnLamp { lamp: name.clone(), to: lamp(name)?.pose.rotation },
            Edit::Light { lamp: name, .. } => Edit::Light { lamp: name.clone(), intensity: lamp(name)?.intensity },
            Edit::Switch { lamp: name, .. } => Edit::Switch { lamp: name.clone(), on: lamp(name)?.lit },
            Edit::Relamp { lamp: name, intensity, .. } => {
                let was = lamp(name)?;
                let relamp = |intensity| Edit::Relamp { lamp: name.clone(), photometry: was.entry.photometry.clone(), intensity };
                if intensity.is_none() {
                    relamp(None)
                } else {
                    let mut back = vec![relamp(Some(was.rated))];
                    if was.rated != was.intensity {
                        back.push(Edit::Light { lamp: name.clone(), intensity: was.intensity });
                    }
                    return Ok(back);
                }
            }
            Edit::AddLamp(entry) => Edit::RemoveLamp { lamp: entry.name.clone() },
            Edit::DuplicateLamp { name, .. } => Edit::RemoveLamp { lamp: name.clone() },
            Edit::RemoveLamp { lamp: name } => Edit::AddLamp(lamp(name)?.stated()),
        };
        Ok(vec![back])
    }

    /// `back`, and what this edit read from meshes' own files is forgotten.
    fn and_forget(&self, back: Edit, before: &Configuration) -> Result<Vec<Edit>, SceneError> {
        let after = before.apply(self)?;
        let new = after.state().materials.keys().filter(|name| !before.state().materials.contains_key(*name));
        Ok([back].into_iter().chain(new.map(|name| Edit::RemoveMaterial { material: name.clone() })).collect())
    }

    /// All that a removal takes away: carriers before what rides on them.
    fn added_again(&self, before: &Configuration) -> Result<Vec<Edit>, SceneError> {
        let after = before.apply(self)?;
        let below =
            |id: usize| std::iter::successors(before.object(id).carrier, |carrier| before.object(*carrier).carrier).count();
        let mut gone: Vec<usize> = before.objects().map(|(id, _)| id).filter(|id| !after.has_object(*id)).collect();
        gone.sort_by_key(|id| below(*id));
        let objects = gone.into_iter().map(|id| Edit::Add(before.object(id).stated()));
        let lamps = before.lamps().filter(|(id, _)| !after.has_lamp(*id)).map(|(_, lamp)| Edit::AddLamp(lamp.stated()));
        Ok(objects.chain(lamps).collect())
    }
}

/// A material that is forgotten: first as the mesh says whose own it is, if it is one, so that it is known as that again.
fn remade(name: &str, before: &Configuration) -> Result<Vec<Edit>, SceneError> {
    let now = before.state().material(name)?;
    let first: &Material = before.state().of_meshes.get(name).unwrap_or(now);
    let (now, first) = (now.stated(), first.stated());
    let material = || name.to_owned();
    let mut back = vec![Edit::AddMaterial { name: material(), reflectance: first.reflectance, texture: first.texture.clone() }];
    if now.reflectance != first.reflectance {
        back.push(Edit::Reflect { material: material(), to: now.reflectance });
    }
    if now.texture != first.texture {
        back.push(Edit::Texture { material: material(), texture: now.texture });
    }
    Ok(back)
}
